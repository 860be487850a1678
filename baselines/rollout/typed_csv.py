"""Reads CSV files of records, and refuses whatever is damaged."""

import io
import warnings
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import pandas as pd
from pandas.errors import ParserWarning

DTYPES: dict[Any, str] = {
    **{int: "int64", float: "float64", bool: "bool", str: "str"},
    **{int | None: "Int64", float | None: "float64", str | None: "object"},
}
"""Types of pandas columns by those of the fields of a record."""


def dtypes(record: type) -> dict[str, str]:
    """Returns the types of the columns of a record's fields, by their names."""
    return {name: DTYPES[kind] for name, kind in get_type_hints(record).items()}


def read(
    path: Path, record: type, heads: Sequence[str], missing: str, optional: Collection[str]
) -> pd.DataFrame:
    """Returns the rows of a file, with a column for each field of a record.

    Args:
        path: of the file.
        record: dataclass, whose fields have the types of ``DTYPES``.
        heads: of the columns in the file.
        missing: text of a cell that holds no value.
        optional: names of the fields that may be missing.

    Raises:
        ValueError: it has other columns, values of other types, or is damaged.
        FileNotFoundError: there is none.
    """
    text, kinds = path.read_text(encoding="utf-8"), dtypes(record)
    if text.partition("\n")[0] != ",".join(heads):
        raise ValueError(f"its columns must be {', '.join(heads)}")
    if not text.endswith("\n"):
        raise ValueError("its last line is torn")
    try:
        with warnings.catch_warnings(), np.errstate(invalid="ignore"):
            warnings.simplefilter("error", ParserWarning)  # such as of rows that are too long
            rows = pd.read_csv(
                io.StringIO(text, newline=""),
                names=list(kinds),
                header=0,
                dtype=kinds,
                index_col=False,
                keep_default_na=False,
                na_values=[missing],
            )
    except (TypeError, OverflowError, ParserWarning) as error:
        raise ValueError(str(error)) from error
    if rows.drop(columns=list(optional)).isna().any(axis=None):
        raise ValueError("a cell is empty that must not be")
    return rows
