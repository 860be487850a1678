"""The engine rllib: PPO of Ray RLlib."""
