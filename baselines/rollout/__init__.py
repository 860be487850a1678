"""One loop that runs policies in worlds, and what an episode leaves."""
