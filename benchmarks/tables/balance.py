# SPDX-License-Identifier: Apache-2.0
"""How evenly the rasterization of a frame is shared out."""
from tables.frames import Frames, label
from tables.growth import BEST
from tables.markdown import count, prose, significant, table
from tables.source import machine_name


def balance(source, machine):
    """Raster time and balanced time of the best renderer, on the first view of each scene that has them."""
    results = source.results(machine, "matrix.json")
    frames, rows = Frames(results), []
    for scene in frames.scenes:
        for row in [row for row in frames.rows(scene, BEST) if row.counted_ms][:1]:
            raster, balanced = row.counted_ms["raster"], row.counted_ms["balanced"]
            rows.append([label(scene), *(significant(1e3 * time) for time in (row.ms["raster"].median, raster, balanced)),
                         significant(raster / balanced if balanced else None), count(row.longest_item),
                         count(row.segments)])
    if not rows:
        return prose(f"No row of `matrix.json` has a balanced time of `{BEST}`.")
    return f"{machine_name(results)}, `{BEST}`, first views, microseconds:\n\n" + table(
        ["scene", "raster", "raster while counting", "balanced", "ratio", "longest item", "segments"], rows)


TABLES = {"balance": balance}
