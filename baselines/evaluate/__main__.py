"""``python -m baselines.evaluate``."""

from baselines.evaluate import main

if __name__ == "__main__":
    main()
