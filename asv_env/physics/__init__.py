"""The motion of all hulls under motors, water and contact."""
