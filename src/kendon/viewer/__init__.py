"""What people look at: the timeline in the terminal and the figures."""
