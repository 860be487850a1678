"""What the boats measure, and what learned policies and critics observe."""
