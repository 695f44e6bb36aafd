# SPDX-License-Identifier: Apache-2.0
"""benchmarks/mpi/model.py: finds again what made its measurements."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = pathlib.Path(__file__).resolve().parent.parent / "mpi" / "model.py"
MS_PER_BYTE, LATENCY = 1e-8, 0.1  # 100 GB/s


def line(scene, ranks, splats, sent, project, strip, **changed):
    """A run in which every rank does the same."""
    exchange = LATENCY + 52 * sent * MS_PER_BYTE if ranks > 1 else 0
    rank = {"visible": splats // ranks, "sent": sent, "drawn": splats // ranks, "project_ms": project, "strip_ms": strip}
    return {"scene": scene, "width": 640, "height": 480, "carrier": "nccl" if ranks > 1 else "host",
            "ms": project + strip + exchange, "ranks": [rank] * ranks, **changed}


class Model(unittest.TestCase):
    def rows(self, lines):
        """Cells of the table without its head."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "frames.jsonl"
            file.write_text("".join(json.dumps(each) + "\n" for each in lines), encoding="utf-8")
            ran = subprocess.run([sys.executable, "-B", PROGRAM, file], capture_output=True, text=True, check=True)
        return [[cell.strip() for cell in row.strip("|").split(" | ")] for row in ran.stdout.splitlines()[4:]]

    def test_a_frame_without_messages_shrinks_by_its_parts(self):
        # Projection takes 1 / N and 0.1 to share out, a strip 0.5 + 1.5 / N; a few splats are sent.
        lines = [line("a", 1, 1000, 0, 1.0, 2.0), line("a", 2, 1000, 250, 0.6, 1.25),
                 line("b", 1, 10**8, 0, 1.0, 2.0), line("b", 2, 10**8, 25 * 10**6, 0.6, 1.25)]
        row = self.rows(lines)[0]
        self.assertEqual(row[3:8], ["3.00 ms", "1.95 ms", f"{0.35 + 0.875 + LATENCY:.2f} ms", "-",
                                    f"{0.225 + 0.6875 + LATENCY:.2f} ms"])

    def test_messages_take_what_carried_as_many_bytes(self):
        lines = [line("a", 1, 1000, 0, 0.0, 3.0), line("a", 2, 1000, 250, 0.0, 3.0),
                 line("b", 1, 10**8, 0, 0.0, 3.0), line("b", 2, 10**8, 25 * 10**6, 0.0, 3.0)]
        row = self.rows(lines)[1]
        sent = 52 * 10**8 / 8
        self.assertEqual(row[-1], f"{sent / 1e6:.1f}")
        self.assertEqual(row[7], f"{3 + LATENCY + sent * MS_PER_BYTE:.2f} ms")
        # A machine sends the other what a rank of two did, through one link of 100 or 400 Gb/s.
        between = 52 * 25 * 10**6 / 12.5e6
        self.assertEqual(row[8:10], [f"{3 + LATENCY + sent * MS_PER_BYTE + share * between:.2f} ms"
                                     for share in (1, 0.25)])

    def test_the_rank_that_sees_most_sends_all_of_it_and_the_one_that_sends_most_fills_the_link(self):
        two = line("a", 2, 10**8, 20 * 10**6, 0.0, 3.0)
        two["ranks"] = [{**two["ranks"][0], "visible": 40 * 10**6},
                        {**two["ranks"][0], "visible": 60 * 10**6, "sent": 10 * 10**6}]
        row = self.rows([line("a", 1, 10**8, 0, 0.0, 3.0), two])[0]
        self.assertEqual(row[-1], f"{52 * 60e6 * 2 / 8 / 1e6:.1f}")
        self.assertAlmostEqual(float(row[8].split()[0]) - float(row[7].split()[0]), 52 * 20e6 / 12.5e6, delta=0.02)

    def test_eight_follow_from_four_where_four_were_measured(self):
        lines = [line("a", 1, 1000, 0, 1.0, 2.0), line("a", 2, 1000, 250, 0.6, 1.25),
                 line("a", 4, 1000, 200, 0.453, 0.5), line("b", 4, 10**8, 25 * 10**6, 0.453, 0.5)]
        row = self.rows(lines)[0]
        # Sharing takes 0.203, and a strip 2 / N.
        self.assertEqual(row[5:8], [f"{0.35 + 0.875 + LATENCY:.2f} ms", f"{0.453 + 0.5 + LATENCY:.2f} ms",
                                    f"{0.125 + 0.203 + 0.25 + LATENCY:.2f} ms"])

    def test_the_quickest_of_several_runs_counts_and_runs_on_one_rank_must_be_there(self):
        slow = line("a", 2, 1000, 250, 0.6, 1.25, ms=99.0)
        lines = [line("a", 1, 1000, 0, 1.0, 2.0), slow, line("a", 2, 1000, 250, 0.6, 1.25),
                 line("c", 2, 1000, 250, 0.6, 1.25)]
        rows = self.rows(lines)
        self.assertEqual([row[0] for row in rows], ["a"])
        self.assertEqual(rows[0][4], f"{0.6 + 1.25 + LATENCY + 52 * 250 * MS_PER_BYTE:.2f} ms")


if __name__ == "__main__":
    unittest.main()
