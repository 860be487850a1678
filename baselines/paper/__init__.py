"""The paper's laws, and its controller."""
