"""Files of networks by their endings and their content."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from pipenav.errors import ConfigError, shown
from pipenav.networks.csv_lines import read_csv_lines
from pipenav.networks.epanet import read_epanet
from pipenav.networks.fields import ReadOptions
from pipenav.networks.geojson import read_geojson
from pipenav.networks.model import NetworkMap, Note
from pipenav.networks.pandapipes_file import is_pandapipes, read_pandapipes
from pipenav.networks.pcf import read_pcf
from pipenav.networks.shapefile_lines import read_shapefile
from pipenav.networks.text import network_json
from pipenav.storage.text_files import shown_path

ENDINGS = (".inp", ".json", ".geojson", ".csv", ".shp", ".pcf")
"""Endings of files that can be read."""


def read_network_map(path: Path, options: ReadOptions | None = None) -> NetworkMap:
    """The map of a network's file.

    Args:
        path: an EPANET .inp, a pandapipes .json, a .geojson, a .csv of lines, a .shp or a .pcf file.
        options: what the file does not say itself.

    Raises:
        FileProblem: the file cannot be read.
        PipenavError: a library is missing.
        ConfigError: the file is of no format that is known, or does not fit its format; with the line or feature.
    """
    options = options or ReadOptions()
    ending = path.suffix.lower()
    if ending == ".inp":
        made = read_epanet(path)
    elif ending in (".json", ".geojson"):
        content = network_json(path)
        made = read_pandapipes(path, content) if is_pandapipes(content) else read_geojson(path, options, content)
    elif ending == ".csv":
        made = read_csv_lines(path, options)
    elif ending == ".shp":
        made = read_shapefile(path, options)
    elif ending == ".pcf":
        made = read_pcf(path)
    else:
        raise ConfigError(
            f"{shown(shown_path(path))} is of an unknown format: give a file that ends in {', '.join(ENDINGS)}."
        )
    return _with_services(made, options.service_bore)


def _with_services(made: NetworkMap, bore: float) -> NetworkMap:
    """The map with all lines of at most a bore as services [m]."""
    narrow = made.diameter <= bore  # False where no diameter is known
    added = int((narrow & ~made.service).sum())
    if not added:
        return made
    note = Note("services-by-bore", "assumed", f"lines of at most {bore * 1e3:g} mm were taken for services", added)
    return dataclasses.replace(made, service=np.asarray(made.service | narrow), notes=(*made.notes, note))
