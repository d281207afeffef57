"""Experiments: the thesis's again (3.6.4), more of ours, and random encounters in closed loop."""
