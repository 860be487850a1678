"""Policies without learning, the control laws and paths behind them, and their evaluation."""
