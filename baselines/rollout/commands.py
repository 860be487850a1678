"""Commands that end with a message instead of a traceback where something is wrong."""

import sys
from collections.abc import Callable, Sequence

import tyro


def command(function: Callable[..., object], program: str) -> Callable[..., None]:
    """Returns a ``main`` that calls a function with what a command line gives as its arguments.

    Where the function raises a ValueError, OSError or ImportError, the program exits with it.
    """

    def main(arguments: Sequence[str] | None = None) -> None:
        try:
            tyro.cli(function, args=arguments, prog=program)
        except (ValueError, OSError, ImportError) as error:
            sys.exit(f"{program}: {error}")
        except KeyboardInterrupt:
            sys.exit(f"{program}: stopped; give the same command to continue")

    return main
