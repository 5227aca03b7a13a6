#!/usr/bin/env python3
"""What do a full disk, a read-only folder, a clock set back and damaged records do to a sweep?

    cargo build --release && python3 benches/sweeps/damage.py    # as root: mounts small file systems; needs faketime

Each case runs the smallest sweep of cases.py and is judged by the exit code, by the lines on standard error, and by
whether the folder can be gone on with to the table of a sweep that nothing befell, byte by byte.
"""

import random
import subprocess
import sys
import tempfile
from pathlib import Path

from cases import CASES, DISC_SWEEP

CASE = CASES["disc"]
WORK = Path(tempfile.mkdtemp(prefix="tirtouch-damage-"))
ROWS = []


def run(out, *more, before=()):
    return subprocess.run([*before, *map(str, CASE.command(out, *more))], cwd=WORK, capture_output=True, text=True)


def mounted(name, options):
    place = WORK / name
    place.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", place], check=True)
    return place


def judged(case, done, codes, expected, folder, *more):
    """One line that names no passing file, the right exit code, and the same table in the end."""
    lines = done.stderr.strip().splitlines()
    told = done.returncode in codes and len(lines) == (done.returncode != 0) and ".tmp" not in done.stderr
    again = run(folder, "--resume", *more)
    table = WORK / folder / "points.csv"
    same = table.exists() and table.read_bytes() == expected
    ROWS.append((case, told and again.returncode == 0 and same, done.returncode, lines[-1] if lines else "-"))


def main():
    ends, _ = CASE.whole(WORK)
    table = ends["points.csv"]

    # So full that some records fit and others do not; then there is room.
    for kib in (24, 48, 64, 80, 100, 112, 124):
        name = f"full-{kib}"
        place = mounted(name, f"size={kib}k")
        done = run(f"{name}/out")
        subprocess.run(["mount", "-o", "remount,size=16m", place], check=True)
        judged(f"disk of {kib} KiB", done, (0, 3) if kib > 100 else (3,), table, f"{name}/out")
        subprocess.run(["umount", place], check=True)

    # Full before it begins: no file is left of what was tried.
    place = mounted("no-room", "size=16k")
    (place / "fill").write_bytes(bytes(16 << 10))
    done = run("no-room/out")
    files = [path.name for path in place.rglob("*") if path.is_file()]
    ROWS.append(("no file left on a full disk", files == ["fill"], done.returncode, " ".join(files)))
    subprocess.run(["mount", "-o", "remount,size=16m", place], check=True)
    judged("full disk", done, (2, 3), table, "no-room/out")
    subprocess.run(["umount", place], check=True)

    # Files run out before bytes do.
    place = mounted("inodes", "size=16m,nr_inodes=20")
    done = run("inodes/out")
    subprocess.run(["mount", "-o", "remount,nr_inodes=1000", place], check=True)
    judged("file system of 20 files", done, (3,), table, "inodes/out")
    subprocess.run(["umount", place], check=True)

    # Nothing can be written: before the sweep, and from its middle on.
    place = mounted("closed", "size=16m")
    subprocess.run(["mount", "-o", "remount,ro", place], check=True)
    done = run("closed/out")
    subprocess.run(["mount", "-o", "remount,rw", place], check=True)
    run("closed/out")
    judged("read-only folder", done, (2, 3), table, "closed/out")
    for record in sorted((place / "out/items").glob("0*.json"))[5:]:
        record.unlink()
    subprocess.run(["mount", "-o", "remount,ro", place], check=True)
    done = run("closed/out", "--resume")
    subprocess.run(["mount", "-o", "remount,rw", place], check=True)
    judged("read-only from the sixth point on", done, (2, 3), table, "closed/out")
    subprocess.run(["umount", place], check=True)

    # A clock set back by a day, and by forty years, between and during runs.
    for case, moved in (("a day back", "-1d"), ("forty years back", "-40y"), ("a year ahead", "+1y")):
        name = "clock" + moved
        assert run(name).returncode == 0
        for record in sorted((WORK / name / "items").glob("0*.json"))[::2]:
            record.unlink()
        done = run(name, "--resume", before=("faketime", "-f", moved))
        judged(f"clock {case}", done, (0,), table, name)

    # Records cut short, changed, emptied, and of another point.
    draw = random.Random(1)
    assert run("records").returncode == 0
    for number in range(40):
        records = sorted((WORK / "records/items").glob("0*.json"))
        victim = draw.choice(records)
        body = victim.read_bytes()
        fault = number % 4
        if fault == 0:
            victim.write_bytes(body[: draw.randrange(len(body))])
        elif fault == 1:
            at = draw.randrange(len(body))
            victim.write_bytes(body[:at] + bytes([body[at] ^ (1 << draw.randrange(8))]) + body[at + 1 :])
        elif fault == 2:
            victim.write_bytes(b"")
        else:
            victim.write_bytes(draw.choice(records).read_bytes())
        done = run("records", "--resume")
        if done.returncode in (2, 3):
            # Refused: the user is told which, and takes it away.
            named = victim.name in done.stderr
            victim.unlink()
            run("records", "--resume")
            if not named:
                ROWS.append((f"record {number}", False, done.returncode, done.stderr.strip()))
        found = (WORK / "records/points.csv").read_bytes()
        if found != table:
            what = ["cut", "a bit", "empty", "another"][fault]
            ROWS.append((f"record {number} ({what})", False, done.returncode, "another table"))
            victim.unlink(missing_ok=True)
            run("records", "--resume")
    ROWS.append(("40 damaged records", not any(row[0].startswith("record ") for row in ROWS), 0, "-"))

    # What tells which sweep the records are of.
    assert run("order").returncode == 0
    (WORK / "order/items/order.json").write_text("{")
    done = run("order", "--resume")
    said = done.stderr.strip()
    good = done.returncode == 2 and len(said.splitlines()) == 1 and "order.json" in said
    good = good and run("order", "--force").returncode == 0
    ROWS.append(("damaged order", good and (WORK / "order/points.csv").read_bytes() == table, done.returncode, said))

    # Another sweep on the same folder.
    (WORK / "sweep.toml").write_text(DISC_SWEEP.replace("values = [3, 4]", "values = [3, 5]"))
    done = run("whole", "--resume")
    said = done.stderr.strip()
    ROWS.append(("another sweep", done.returncode == 2 and len(said.splitlines()) == 1, done.returncode, said))

    for case, good, code, line in ROWS:
        print(f"{'ok ' if good else 'BAD'} {case}: exit {code}: {line.replace(str(WORK), '')[:160]}")
    sys.exit(not all(row[1] for row in ROWS))


if __name__ == "__main__":
    main()
