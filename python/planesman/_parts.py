"""A dataset of Parquet files, one per part: each is written completely or not at all, here or by the workers of a Dask cluster.

A part depends only on its number. If a worker dies, another one computes its part again; a complete part is
not computed again; two workers that compute the same part write the same rows under one name. So nothing is lost or duplicated.
"""

from __future__ import annotations

import errno
import functools
import os
import socket
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from planesman._arguments import path_text
from planesman._native import PlanesmanError
from planesman._progress import Progress

if TYPE_CHECKING:
    import pyarrow
    from distributed import Client

# Computes the rows of part `part` of `of`, from 1 on, and tells `told`, if there is one, how many are done. Workers get it by pickle.
Work = Callable[..., "pyarrow.Table"]


def default_parts(items: int, of_one: int) -> int:
    """Number of parts: each has a limited number of items, and a small job has some for every worker. It depends only on the job: a folder
    continued by another cluster has the same parts."""
    return max(1, min(items, max(64, -(-items // of_one))))


def path_of(folder: Path, part: int, of: int) -> Path:
    """File name of a part."""
    width = max(4, len(str(of)))
    return folder / f"part-{part:0{width}}-of-{of:0{width}}.parquet"


def is_there(path: Path, rows: int) -> bool:
    """Whether the file is a complete Parquet file with so many rows, according to its footer, which is written last."""
    import pyarrow
    import pyarrow.parquet

    try:
        with path.open("rb") as file:
            return bool(pyarrow.parquet.read_metadata(file).num_rows == rows)
    except (FileNotFoundError, pyarrow.ArrowInvalid):
        return False


def put(path: Path, write: Callable[[BinaryIO], object]) -> None:
    """Write a file under a temporary name, flush it to the disk, and rename it."""
    # Names that begin so are no part for a reader; on any machine no other writes this one.
    draft = path.with_name(f".{uuid.uuid4().hex}.draft")
    try:
        with draft.open("xb") as file:
            write(file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(draft, path)
        _sync(path.parent)
    finally:
        draft.unlink(missing_ok=True)


def _sync(folder: Path) -> None:
    file = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(file)
    except OSError as refused:
        # Some file systems cannot.
        if refused.errno != errno.EINVAL:
            raise
    finally:
        os.close(file)


def fill(
    folder: Path,
    parts: int,
    work: Work,
    client: Client | None,
    progress: Progress | None = None,
    rows: Callable[[int, int], int] = lambda part, of: 1,
) -> Path:
    """Compute the missing parts of the folder. `rows`: number of rows of a part, for the progress."""
    if not isinstance(parts, int) or parts < 1:
        raise PlanesmanError(f"parts: {parts} refused: a whole number of 1 or more is expected")
    folder.mkdir(parents=True, exist_ok=True)
    lacking = [part for part in range(1, parts + 1) if not is_there(path_of(folder, part, parts), rows(part, parts))]
    with progress or Progress("parts", wanted=False) as told:
        if client is None:
            told.total = sum(rows(part, parts) for part in lacking)
            if progress is not None:
                work = functools.partial(work, told=told)
            for part in lacking:
                write(folder, part, parts, work, rows(part, parts))
                told.settle()
        elif lacking:
            told.what, told.total = "parts", len(lacking)
            _on_cluster(folder, parts, {part: rows(part, parts) for part in lacking}, work, client, told)
    return folder


def write(folder: Path, part: int, of: int, work: Work, rows: int) -> None:
    """Compute a part with so many rows, unless it exists, and write its file."""
    import pyarrow.parquet

    path = path_of(folder, part, of)
    if is_there(path, rows):
        return
    if not folder.is_dir():
        raise PlanesmanError(f"'{folder}' does not exist on {socket.gethostname()}: name a folder shared by all machines of the cluster")
    table = work(part, of)
    put(path, functools.partial(pyarrow.parquet.write_table, table))


def _on_cluster(folder: Path, parts: int, lacking: dict[int, int], work: Work, client: Client, told: Progress) -> None:
    from distributed import as_completed

    # Sent once to the cluster, not with every part.
    shared = client.scatter(work, broadcast=True, hash=False)
    futures = client.map(lambda part, rows, work: write(folder, part, parts, work, rows), *zip(*lacking.items()), work=shared, pure=False)
    try:
        for done, future in enumerate(as_completed(futures), 1):
            future.result()
            future.release()
            told(done)
    finally:
        client.cancel(futures)


def absolute(folder: str | os.PathLike[str]) -> Path:
    """Absolute path of the folder, for workers with other working directories."""
    return Path(os.path.abspath(path_text(folder)))


def numbers(values: Any) -> Any:
    """An array of numbers as a column, with null for NaN."""
    import pyarrow

    return pyarrow.array(values, from_pandas=True)
