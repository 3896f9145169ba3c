"""A folder for a fleet, on a disk or on any object store that fsspec reaches.

::

    runs/motor=ID/day=YYYY-MM-DD/NAME-<began>-<content>.parquet     what was measured
    labels/motor=ID.json                                             what else is known of a motor
    models/common.json, models/motor=ID.json                         coefficient files, as identified
    refined/common.json, refined/motor=ID.json                       the same with effects that all motors show
    tasks/<kind>-<inputs>.npz                                        what was computed, by what it was computed from
"""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from gen.errors import InputError
from gen.fleet.folder.names import in_time, kept_name, said_beginning, said_day
from gen.fleet.folder.run_bytes import comments_from, content_hash, from_bytes, to_bytes
from gen.runs import Run

RUNS, MODELS, TASKS, INCOMING = "runs", "models", "tasks", ".incoming"
_SHOWN = 16
"""Hexadecimal digits of the content's hash in a file's name: 64 bits, no two of a motor's runs share them by chance."""


@dataclass(frozen=True)
class Kept:
    """A run of the store.

    Attributes
    ----------
    motor, day, name
        Whose, of when, and the run file's name with when it began, where it says that, and a hash of its content.
    """

    motor: str
    day: str
    name: str

    @property
    def path(self) -> str:
        """Within the store."""
        return f"{RUNS}/motor={self.motor}/day={self.day}/{self.name}.parquet"

    @property
    def content(self) -> str:
        """What stands for the content."""
        return self.name[-_SHOWN:]


@dataclass(frozen=True)
class Store:
    """Where a fleet is kept.

    Parameters
    ----------
    url
        A folder's path, or what fsspec takes (``s3://bucket/fleet``, ``memory://fleet``).
    """

    url: str

    @cached_property
    def _reached(self) -> tuple[Any, str]:
        from fsspec.core import url_to_fs

        try:
            files, root = url_to_fs(self.url)
        except (ValueError, ImportError, OSError) as error:
            raise InputError(f"cannot be reached: {error}", file=self.url) from error
        return files, root.rstrip("/")

    @property
    def _now(self) -> tuple[Any, str]:
        """The same, and what it remembers of folders forgotten: other processes have written since."""
        files, root = self._reached
        files.invalidate_cache()
        return files, root

    @property
    def absolute(self) -> str:
        """The URL as a process with another current folder has to have it."""
        files, root = self._reached
        return str(files.unstrip_protocol(root))

    @property
    def of_one_process(self) -> bool:
        """Whether no other process sees what is in it."""
        return "memory" in _protocols(self._reached[0])

    def exists(self, path: str = "") -> bool:
        """Whether there is such a file or folder."""
        files, root = self._now
        with self._naming(path):
            return bool(files.exists(f"{root}/{path}".rstrip("/")))

    def read(self, path: str) -> bytes:
        """Read a file.

        Raises
        ------
        InputError
            When it cannot be read.
        """
        files, root = self._now
        with self._naming(path):
            return bytes(files.cat_file(f"{root}/{path}"))

    def write(self, path: str, data: bytes) -> None:
        """Write a file beside the others and move it to its place: no reader sees half of it.

        Raises
        ------
        InputError
            When it cannot be written.
        """
        files, root = self._reached
        target, beside = f"{root}/{path}", f"{root}/{INCOMING}/{uuid.uuid4().hex}"
        with self._naming(path):
            try:
                files.makedirs(f"{root}/{INCOMING}", exist_ok=True)
                files.makedirs(target.rpartition("/")[0], exist_ok=True)
                files.pipe_file(beside, data)
                files.mv(beside, target)
            except BaseException:
                if files.exists(beside):
                    files.rm_file(beside)
                raise

    def remove(self, path: str) -> None:
        """Remove a file, where it is.

        Raises
        ------
        InputError
            When it cannot be removed.
        """
        files, root = self._reached
        with self._naming(path), suppress(FileNotFoundError):
            files.rm_file(f"{root}/{path}")

    def names(self, folder: str) -> list[str]:
        """Give the names of what is in a folder, sorted; none where it is missing."""
        files, root = self._now
        with self._naming(folder):
            try:
                found = files.ls(f"{root}/{folder}", detail=False)
            except (FileNotFoundError, NotADirectoryError):
                return []
        return sorted(str(path).rstrip("/").rpartition("/")[2] for path in found)

    def motors(self) -> list[str]:
        """Give the motors that have runs, sorted."""
        found = (name.partition("=") for name in self.names(RUNS))
        return [value for key, _, value in found if key == "motor" and value]

    def runs(self, motor: str) -> list[Kept]:
        """Give a motor's runs in time; see :func:`gen.fleet.folder.names.in_time`."""
        found = []
        for folder in self.names(f"{RUNS}/motor={motor}"):
            day = folder.removeprefix("day=")
            for name in self.names(f"{RUNS}/motor={motor}/{folder}"):
                if name.endswith(".parquet"):
                    found.append(Kept(motor, day, name.removesuffix(".parquet")))
        return sorted(found, key=lambda kept: in_time(kept.day, kept.name))

    def add(self, motor: str, day: str, name: str, run: Run) -> tuple[Kept, bool]:
        """Keep a run.

        Parameters
        ----------
        motor, day
            Checked by `names`.
        name
            Of its file.
        run
            What it holds.

        Returns
        -------
        kept, new
            Where it is, and whether it was not there before: the same content under whatever name and day is.
        """
        content = content_hash(run)[:_SHOWN]
        for kept in self.runs(motor):
            if kept.content == content:
                return kept, False
        first_s = float(run.time_s[0])
        # Somebody who gives another day does not trust the run's clock.
        trusted = said_day(run.comments, first_s) == day
        began = said_beginning(run.comments, first_s) if trusted else ""
        kept = Kept(motor, day, kept_name(name, began, content))
        self.write(kept.path, to_bytes(run))
        return kept, True

    def run(self, kept: Kept) -> Run:
        """Read a run.

        Raises
        ------
        InputError
            When it cannot be read, or is none.
        """
        return from_bytes(self.read(kept.path), f"{self.url}/{kept.path}")

    def comments(self, kept: Kept) -> dict[str, str]:
        """Read what a run says of itself, without its rows; raises as :meth:`run` does."""
        files, root = self._now
        with self._naming(kept.path), files.open(f"{root}/{kept.path}", "rb") as stream:
            return comments_from(stream, f"{self.url}/{kept.path}")

    @contextmanager
    def _naming(self, path: str) -> Iterator[None]:
        try:
            yield
        except InputError:
            raise
        except Exception as error:  # each plug-in has kinds of its own, beside OSError
            said = getattr(error, "strerror", None) or str(error) or type(error).__name__
            raise InputError(f"cannot be reached: {said}", file=f"{self.url}/{path}".rstrip("/")) from error


def _protocols(files: Any) -> tuple[str, ...]:  # noqa: ANN401 - fsspec has no types
    named = files.protocol
    return (named,) if isinstance(named, str) else tuple(named)
