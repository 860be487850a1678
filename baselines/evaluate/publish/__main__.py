"""``python -m baselines.evaluate.publish``."""

from baselines.evaluate.publish.pages import main

if __name__ == "__main__":
    main()
