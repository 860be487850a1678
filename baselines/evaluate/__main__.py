"""``python -m baselines.evaluate``."""

import signal
import sys

if __name__ == "__main__":
    try:
        from baselines.evaluate import main

        main()
    except KeyboardInterrupt:
        sys.exit("\nstopped")
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # there is nothing left to stop
