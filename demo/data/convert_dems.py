#!/usr/bin/python3
"""Turns the elevation data of two Debian packages into 16-bit TIFFs for tilth's demo.

Usage: convert_dems.py FOLDER [--jacksboro FILE.npz] [--etopo FILE.cdf]

    jacksboro.tif      the Jacksboro fault, Tennessee; 403 x 344 posts, 3 arc seconds (about 93 m north-south and 75 m
                       east-west), 236 to 1 076 m; Debian package python-matplotlib-data
    etopo5.tif         the whole Earth, 4 320 x 2 161 posts of 5 arc minutes, sea floor to summit; package ferret-datasets
    etopo5_alps.tif    a cut of it: 2 to 20 degrees east, 42 to 50 north, 217 x 97 posts

Each TIFF is uncompressed, 16-bit unsigned grey. Row 0 is the northern edge, so x runs east and z south. The description
(tag 270) reads "tilth: scale=S offset=O source=...": height in metres = value * S + O. Heights of whole metres are
stored exactly, with scale 1. Needs /usr/bin/python3 with Debian's python3-numpy; reads netCDF-3 by itself.
A file that is not there or has another form than expected is an error on standard error, exit status 1.
"""

import argparse
import math
import os
import struct
import sys

import numpy as np

JACKSBORO = "/usr/share/matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz"
ETOPO = "/usr/share/ferret-vis/data/etopo5.cdf"


class DataError(Exception):
    """Data that is not what it should be; the message names the file."""


# ---- out ----

def write_tiff16(path, values, description):
    """Uncompressed little-endian TIFF, one strip, written beside its name first and then renamed."""
    depth, width = values.shape
    text = description.encode("ascii") + b"\0"
    text += b"\0" * (len(text) % 2)
    strip = values.astype("<u2").tobytes()
    entries = 11
    text_at = 8 + 2 + 12 * entries + 4
    strip_at = text_at + len(text)

    def short(tag, value):
        return struct.pack("<HHIHH", tag, 3, 1, value, 0)

    def long(tag, value):
        return struct.pack("<HHII", tag, 4, 1, value)

    directory = b"".join([
        long(256, width), long(257, depth), short(258, 16), short(259, 1), short(262, 1),  # size, bits, no compression, grey
        struct.pack("<HHII", 270, 2, len(text), text_at),
        long(273, strip_at), short(277, 1), long(278, depth), long(279, len(strip)), short(339, 1)])
    with open(path + ".part", "wb") as file:
        file.write(b"II*\0" + struct.pack("<I", 8) + struct.pack("<H", entries) + directory + struct.pack("<I", 0))
        file.write(text + strip)
    os.replace(path + ".part", path)


def convert(path, heights_m, source):
    """Stores `heights_m` in 16 bits: in whole metres where the data has no finer ones, else over its exact range."""
    low, high = float(heights_m.min()), float(heights_m.max())
    whole = bool((heights_m == np.floor(heights_m)).all()) and high - low <= 65535
    scale = 1.0 if whole else (high - low) / 65535
    offset = low
    values = np.floor((heights_m.astype(np.float64) - offset) / scale + 0.5).astype(np.uint16)
    write_tiff16(path, values, f"tilth: scale={scale!r} offset={offset!r} source={source}")
    depth, width = values.shape
    print(f"{path}: {width} x {depth} posts, {low:g} to {high:g} m, step {scale:g} m")


# ---- in ----

def read_jacksboro(path):
    with np.load(path) as data:
        if "elevation" not in data:
            raise DataError(f"{path}: has no array 'elevation'")
        heights = data["elevation"]
    if heights.shape != (344, 403):
        raise DataError(f"{path}: elevation is {heights.shape}, expected (344, 403)")
    return heights  # row 0 is north: the file's ymin (36.73) is the larger latitude


class NetCdf3:
    """The variables of a netCDF classic file (versions 1 and 2) without records: name -> (shape, array)."""

    TYPES = {1: "i1", 2: "S1", 3: ">i2", 4: ">i4", 5: ">f4", 6: ">f8"}

    def __init__(self, path):
        with open(path, "rb") as file:
            self.bytes = file.read()
        self.path, self.at = path, 4
        if self.bytes[:3] != b"CDF" or self.bytes[3] not in (1, 2):
            raise DataError(f"{path}: is not a netCDF classic file")
        self.offset_format = ">I" if self.bytes[3] == 1 else ">Q"
        self.take(">I")  # number of records
        dimensions = self.list_of(10, lambda: (self.name(), self.take(">I"))[1])
        self.attributes()
        self.variables = dict(self.list_of(11, lambda: self.variable(dimensions)))

    def take(self, form):
        value = struct.unpack_from(form, self.bytes, self.at)[0]
        self.at += struct.calcsize(form)
        return value

    def name(self):
        length = self.take(">I")
        text = self.bytes[self.at:self.at + length].decode("ascii")
        self.at += -(-length // 4) * 4
        return text

    def list_of(self, tag, element):
        found, count = self.take(">I"), self.take(">I")
        if found not in (0, tag) or (found == 0 and count != 0):
            raise DataError(f"{self.path}: damaged header near byte {self.at}")
        return [element() for _ in range(count)]

    def attributes(self):
        def attribute():
            name, kind, count = self.name(), self.take(">I"), self.take(">I")
            values = np.frombuffer(self.bytes, self.TYPES[kind], count, self.at)
            self.at += -(-values.nbytes // 4) * 4
            return name, values
        return dict(self.list_of(12, attribute))

    def variable(self, dimensions):
        name = self.name()
        shape = [dimensions[self.take(">I")] for _ in range(self.take(">I"))]
        attributes = self.attributes()
        kind = self.TYPES[self.take(">I")]
        self.take(">I")  # size in bytes, which follows from the shape
        begin = self.take(self.offset_format)
        return name, (np.frombuffer(self.bytes, kind, math.prod(shape), begin).reshape(shape), attributes)


def read_etopo(path):
    """Heights with row 0 in the north and column 0 at 0 degrees east; and the latitudes and longitudes."""
    try:
        variables = NetCdf3(path).variables
    except (struct.error, KeyError, IndexError, ValueError, UnicodeDecodeError) as problem:
        raise DataError(f"{path}: damaged netCDF header: {problem}") from problem
    for name in ("ROSE", "ETOPO05_X", "ETOPO05_Y"):
        if name not in variables:
            raise DataError(f"{path}: has no variable {name}")
    heights, attributes = variables["ROSE"]
    east, north = variables["ETOPO05_X"][0], variables["ETOPO05_Y"][0]
    if heights.shape != (2161, 4320):
        raise DataError(f"{path}: ROSE is {heights.shape}, expected (2161, 4320)")
    missing = (heights == attributes["missing_value"][0]) if "missing_value" in attributes else np.zeros(heights.shape, bool)
    if missing.any() or not np.isfinite(heights).all():
        raise DataError(f"{path}: {int(missing.sum())} posts have no data")
    if north[0] < north[-1]:
        heights, north = heights[::-1], north[::-1]
    first = int(np.argmin(np.mod(east, 360.0)))
    return np.roll(heights, -first, axis=1), np.roll(np.mod(east, 360.0), -first), north


def main():
    parser = argparse.ArgumentParser(description="Converts elevation data of Debian packages into 16-bit TIFFs.")
    parser.add_argument("folder", help="where the TIFFs go; made if it does not exist")
    parser.add_argument("--jacksboro", default=JACKSBORO, metavar="FILE.npz")
    parser.add_argument("--etopo", default=ETOPO, metavar="FILE.cdf")
    options = parser.parse_args()
    try:
        os.makedirs(options.folder, exist_ok=True)
        convert(os.path.join(options.folder, "jacksboro.tif"), read_jacksboro(options.jacksboro),
                "jacksboro_fault_dem.npz (python-matplotlib-data)")
        earth, east, north = read_etopo(options.etopo)
        convert(os.path.join(options.folder, "etopo5.tif"), earth, "ETOPO5 (ferret-datasets)")
        rows = (north > 41.96) & (north < 50.04)  # half a post beyond: the file's longitudes are rounded
        columns = (east > 1.96) & (east < 20.04)
        convert(os.path.join(options.folder, "etopo5_alps.tif"), earth[rows][:, columns], "ETOPO5 (ferret-datasets)")
    except (OSError, ValueError, DataError) as problem:
        print(f"convert_dems.py: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
