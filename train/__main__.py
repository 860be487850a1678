"""``python -m train``: see ``train.config.Config`` for the options."""

import sys
from collections.abc import Sequence

MEMORY = "memory is not sufficient: use fewer worlds (--num-envs), fewer steps or smaller layers"


def main(arguments: Sequence[str] | None = None) -> None:
    """Trains as a command line says; exits with a message where something is wrong."""
    try:
        from baselines.rollout.commands import steady
        from train.config import parse

        with steady():
            config = parse(arguments)
            if config.engine == "rllib":
                from train.rllib.engine import train
            else:
                from train.sb3.training import train
            train(config)
        print(f"the best policy of the run: {config.folder / 'best.npz'}")
    except (ValueError, OSError, ImportError, MemoryError) as error:
        sys.exit(f"python -m train: {_with_remedy(error)}")
    except RuntimeError as error:  # torch has no error of its own for this
        if "allocate memory" not in str(error):
            raise
        sys.exit(f"python -m train: {MEMORY}")
    except KeyboardInterrupt:
        sys.exit(
            "python -m train: stopped; the same command, without --overwrite, resumes from the "
            "last checkpoint"
        )


def _with_remedy(error: Exception) -> str:
    """Returns the message of an error in one line; where an extra is missing, says which."""
    if isinstance(error, MemoryError):
        return MEMORY
    from baselines.rollout.extras import remedy

    message = " ".join(str(error).split())
    extra = remedy(error) if isinstance(error, ImportError) else ""
    return f"{message}: this needs an extra, {extra}" if extra else message


if __name__ == "__main__":
    main()
