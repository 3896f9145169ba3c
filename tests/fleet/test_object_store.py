"""A fleet in an S3 bucket, which every process reaches over a socket only, beside the same fleet in a folder.

The server is moto's, on this machine.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import fsspec
import numpy as np
import pytest
from moto.moto_server.threaded_moto_server import ThreadedMotoServer

from gen.fleet.folder.models import COMMON, model_path
from gen.fleet.folder.store import INCOMING, MODELS, Store
from gen.fleet.identify import Identified
from gen.fleet.tasks.work import Workers
from gen.fleet.watch import FILE, watch
from gen.runs import Run, write_run
from tests.command import gen
from tests.fleet.conftest import MOTORS
from tests.fleet.made import run_of

URL = "s3://bucket/plant/fleet"


@pytest.fixture
def bucket(monkeypatch: pytest.MonkeyPatch) -> Iterator[Store]:
    """A store in an empty bucket, and an environment in which it is reached."""
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://{host}:{port}")
    for name, value in (("ACCESS_KEY_ID", "x"), ("SECRET_ACCESS_KEY", "x"), ("DEFAULT_REGION", "us-east-1")):
        monkeypatch.setenv(f"AWS_{name}", value)
    fsspec.filesystem("s3").makedirs("bucket", exist_ok=True)
    yield Store(URL)
    type(fsspec.filesystem("s3")).clear_instance_cache()  # the next server has another port
    server.stop()


def later(number: int) -> Run:
    """A run that is newer than the models; the fifth motor has a sensor that has shifted."""
    rng = np.random.default_rng(1000 + number)
    heat, capacity = np.exp(rng.normal(0.0, 0.08, 2)).tolist()
    return run_of(600 + number, heat=heat, capacity=capacity, offset=12.0 if number == 4 else 0.0, hours=3.0)


def test_a_fleet_in_a_bucket_is_worked_on_as_one_in_a_folder(
    bucket: Store, identified: tuple[Path, Identified], tmp_path: Path
) -> None:
    shutil.copytree(identified[0], tmp_path / "here")
    here = Store(str(tmp_path / "here"))
    for motor in here.motors():
        for kept in here.runs(motor):
            bucket.write(kept.path, here.read(kept.path))
    done = gen("fleet", "identify", URL, "--until", "2026-01-31", "--max-hidden", "0", "--scouts", "1", "--jobs", "2")
    assert done.returncode == 0, done.stderr
    assert bucket.names(MODELS) == here.names(MODELS)
    for path in (COMMON, *(model_path(f"m{number}") for number in range(MOTORS))):
        assert bucket.read(path) == here.read(path), path

    write_run(tmp_path / "later.csv", later(0))
    for url in (URL, here.url):
        add = [
            "fleet",
            "add",
            "later.csv",
            "--motor",
            "m0",
            "--to",
            url,
            "--day",
            "2026-02-01",
            "--label",
            "supplier=A",
        ]
        done = gen(*add, cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith("m0: supplier=A\nlater.csv: runs/motor=m0/day=2026-02-01/later-")
        for number in range(1, MOTORS):
            Store(url).add(f"m{number}", "2026-02-01", "later", later(number))
    done = gen("fleet", "watch", URL, "--jobs", "2", "--level", "0.05")
    assert (done.returncode, done.stderr) == (0, "")
    assert "m4: sensor differs: of casing, by +1" in done.stdout
    watch(here, 0.05, Workers(), lambda _: None)
    assert bucket.read(FILE) == here.read(FILE)
    done = gen("fleet", "report", URL, "--out", "pages", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "supplier=A" in (tmp_path / "pages" / "motors" / "m0.html").read_text()
    assert bucket.names(INCOMING) == []


@pytest.mark.parametrize(
    ("name", "value"), [("AWS_ENDPOINT_URL", "http://127.0.0.1:9"), ("AWS_ACCESS_KEY_ID", None)], ids=str
)
def test_a_bucket_that_is_not_reached_is_one_line(
    bucket: Store, monkeypatch: pytest.MonkeyPatch, name: str, value: str | None
) -> None:
    if value is None:
        monkeypatch.delenv(name)
        monkeypatch.delenv("AWS_SECRET_ACCESS_KEY")
        monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")
    else:
        monkeypatch.setenv(name, value)
        monkeypatch.setenv("AWS_MAX_ATTEMPTS", "1")
    done = gen("fleet", "watch", URL)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert done.stderr.startswith(f"error: {URL}")
