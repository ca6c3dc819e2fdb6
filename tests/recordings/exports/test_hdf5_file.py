"""A disk that fills up while an HDF5 file is written."""

from pathlib import Path

import numpy as np
import pytest

from movingout.recordings.exports.hdf5_file import hdf5_file


def test_a_full_disk_is_one_error_and_nothing_else(capfd: pytest.CaptureFixture[str]) -> None:
    """The library told of it by dozens of lines and a RuntimeError."""
    with pytest.raises(OSError, match="No space left"), hdf5_file(Path("/dev/full")) as file:
        file.create_dataset("x", data=np.zeros(1000))
    assert capfd.readouterr().err == ""
