"""What is to be done: initial states, reward, termination, metrics."""
