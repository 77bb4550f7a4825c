"""Takes the gas network of Schutterwald out of pandapipes' wheel, without what a map does not need.

    pip download --no-deps pandapipes==0.16.0
    python convert.py pandapipes-0.16.0-py3-none-any.whl

The network belongs to pandapipes, whose licence lies beside this file.
"""

from __future__ import annotations

import json
import sys
import zipfile
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
MEMBER = "pandapipes/networks/network_files/gas_net_schutterwald_1bar.json"

COLUMNS = {
    "junction": ("name", "height_m"),
    "junction_geodata": ("x", "y"),
    "pipe": ("name", "from_junction", "to_junction", "length_km", "diameter_m", "type", "stanet_std_type"),
}
"""Tables and columns of a map; fluids, sinks and results are left out."""


def converted(network: dict[str, Any]) -> dict[str, Any]:
    """A network of pandapipes with the columns of a map alone."""
    tables = {}
    for name, columns in COLUMNS.items():
        table = json.loads(network["_object"][name]["_object"])
        at = [table["columns"].index(column) for column in columns]
        data = [[row[i] for i in at] for row in table["data"]]
        held = json.dumps({"columns": columns, "index": table["index"], "data": data}, separators=(",", ":"))
        tables[name] = {"_module": "pandas.core.frame", "_class": "DataFrame", "_object": held, "orient": "split"}
    return {"_module": "pandapipes.pandapipes_net", "_class": "pandapipesNet", "_object": tables}


def main() -> None:
    """Write network.json and LICENSE beside this file."""
    wheel = zipfile.ZipFile(sys.argv[1])
    made = converted(json.loads(wheel.read(MEMBER)))
    (HERE / "network.json").write_text(json.dumps(made) + "\n", encoding="utf-8")
    licence = next(name for name in wheel.namelist() if name.endswith("LICENSE"))
    (HERE / "LICENSE").write_bytes(wheel.read(licence))


if __name__ == "__main__":
    main()
