"""The engine sb3: PPO of stable-baselines3."""
