"""The browser's view of an encounter: watch one, take part in one, save one as a page.

`stage` and `session` run the encounter and know no browser; `scene`, `controls` and `server`
show it through viser; `replay` writes it into a page of its own.
"""
