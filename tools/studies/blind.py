#!/usr/bin/python3
"""How well does the diagnosis name effects that are withheld from it?

Makes cases, seals their truth, diagnoses each from its scan alone, scores the answers and writes the page. Every step
that is done is not repeated: a study that was stopped goes on with the same command.
"""

import argparse
import json
import os
import pathlib
import shlex
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from provenance import SOURCE, UMOV, commit, machine  # noqa: E402

UNMADE = "no material and size of the wanted effect give the wanted ρ"  # umov's own words
DIAGNOSIS = ("host/gap", "host/brdf", "host/optics", "host/calibrate", "host/invert", "host/formats")


def umov(*arguments):
    """Runs umov; returns its stdout. Errors end the study with the program's own message."""
    done = subprocess.run([UMOV, *map(str, arguments)], text=True, stdout=subprocess.PIPE, check=False)
    if done.returncode != 0:
        raise SystemExit(done.returncode)
    return done.stdout


def diagnosis_commit():
    """The commit, and whether the code that diagnoses was another than it says."""
    done = subprocess.run(["git", "-C", SOURCE, "status", "--porcelain", "--", *DIAGNOSIS], text=True,
                          capture_output=True, check=False)
    return commit() + (" with uncommitted changes" if done.stdout.strip() else "")


def launcher(options):
    """What stands before `umov blind run`: mpirun where it is there."""
    if options.launcher is not None:
        return shlex.split(options.launcher), dict(os.environ)
    if options.jobs == 1 or not shutil.which("mpirun"):
        return [], dict(os.environ)
    environment = dict(os.environ)
    if os.geteuid() == 0:  # in containers; Open MPI asks for both
        environment |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(options.jobs)], environment


def make(folder, cases, seed, *further):
    """A sealed set in `folder`, unless it is there; False where no case of the wanted effect is that large."""
    if (folder / "cases/SEAL").exists():
        umov("blind", "check", folder / "cases", "--truth", folder / "sealed", "--quiet")
        truth = json.loads((folder / "sealed/truth.json").read_text(encoding="utf-8"))
        if truth["seed"] != seed or len(truth["cases"]) != cases:
            raise SystemExit(f"{folder} holds {len(truth['cases'])} cases of seed {truth['seed']}: "
                             "repeat these or name another --folder")
        return True
    for part in ("cases", "sealed"):  # a set without a seal is half made
        shutil.rmtree(folder / part, ignore_errors=True)
    folder.mkdir(parents=True, exist_ok=True)
    done = subprocess.run([UMOV, "blind", "make", folder / "cases", "--truth", folder / "sealed", "--cases", str(cases),
                           "--seed", str(seed), *map(str, further)], stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE if further else None, text=True, check=False)
    if done.returncode == 130:
        raise SystemExit(130)
    if done.returncode == 0:
        return True
    if UNMADE in (done.stderr or ""):
        return False
    sys.stderr.write(done.stderr or "")
    raise SystemExit(done.returncode)


def run(folder, options, *further):
    before, environment = launcher(options)
    command = [*before, UMOV, "blind", "run", folder / "cases", "--truth", folder / "sealed", "--commit",
               diagnosis_commit(), *further]
    if not before:
        command += ["--threads", str(options.jobs)]
    if options.quick:
        command.append("--quick")
    done = subprocess.run(list(map(str, command)), env=environment, check=False)
    if done.returncode != 0:
        print("stopped; the same command goes on", file=sys.stderr)
        raise SystemExit(done.returncode)


def record(folder):
    return json.loads((folder / "cases/RUN.json").read_text(encoding="utf-8"))


def left_out_rows(folder, options):
    """For each effect of the catalogue: cases with it alone, diagnosed without it."""
    rows, unmade = {}, []
    for effect in json.loads(umov("blind", "effects", "--json")):
        if not effect["in_catalogue"]:
            continue
        name = effect["effect"]
        own = folder / "left_out" / name
        # Where no size that a bench may have is that plain, a smaller one.
        made = any(make(own, options.left_out, options.seed + 1, "--effect", name, "--rho-min", low, "--rho-max", high)
                   for low, high in ((8, 50), (1, 50)))
        if not made:
            unmade.append(name)
            continue
        run(own, options, "--leave-out", "--followups", 0, "--without-floors", "--quiet")
        rows |= json.loads(umov("blind", "score", own / "cases", "--truth", own / "sealed", "--json"))["left_out"]
        print(f"left out {name}: {rows.get(name)}", flush=True)
    return rows, unmade


def left_out_section(rows, unmade, options):
    lines = ["## Each effect left out of the catalogue", "",
             f"{options.left_out} cases with it alone (ρ 8–50, or from 1 where none can be made so large), seed {options.seed + 1}, "
             "own scan only, diagnosed by a catalogue without it. *Flagged*: `unexplained` or `explained_in_part`.", "",
             "| effect left out | cases | flagged | explained by others | by a richer reflectance | not seen | taken for |",
             "|---|---|---|---|---|---|---|"]
    total = dict.fromkeys(("n", "flagged", "mimicked", "absorbed", "unseen"), 0)
    for name, row in rows.items():
        for key in total:
            total[key] += row[key]
        lines.append(f"| `{name}` | {row['n']} | {row['flagged']} | {row['mimicked']} | {row['absorbed']} | {row['unseen']} | "
                     f"{', '.join(row['mimics'])} |")
    lines.append(f"| all | {total['n']} | {total['flagged']} | {total['mimicked']} | {total['absorbed']} | {total['unseen']} | |")
    if unmade:
        lines += ["", f"No case could be made of {', '.join(f'`{name}`' for name in unmade)}: none of the materials drawn brings it to "
                  "ρ = 1 within the sizes that a bench may have."]
    return lines + [""]


def page(folder, options, sections):
    said = record(folder)
    command = f"./dev study blind --cases {options.cases} --seed {options.seed}"
    if options.left_out:
        command += f" --left-out {options.left_out}"
    if options.quick:
        command += " --quick"
    return ["# How well are withheld effects named?", "",
            "Scans of an emulated instrument with drawn material, plan and noise, in which no effect, one, several, an unknown one",
            "or a crowd of them is hidden (`hil/blind/README.md`). Each is diagnosed from its file alone; the truth was sealed before.",
            "What each measure counts is defined in `host/gap/benchmark/README.md`. Intervals hold 95 %: proportions by Clopper and",
            "Pearson, other figures by the bootstrap over cases. *Surely*: the whole interval lies on that side of the target.",
            "How far one who knows all but the effect gets with a single one is in [ceilings.md](ceilings.md).", "",
            f"Command `{command}`, commit of the diagnosis {said['program']['commit']}, {machine()}.", "", *sections]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", default=None, help="where cases, truth and answers are kept; else build/studies/blind-SEED")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes")
    parser.add_argument("--launcher", help="instead of mpirun -n JOBS, such as 'mpirun -n 64 --hostfile hosts'")
    parser.add_argument("--left-out", type=int, default=0, metavar="K",
                        help="also K cases of each effect of the catalogue, diagnosed without it")
    parser.add_argument("--quick", action="store_true", help="a shorter search")
    parser.add_argument("-o", "--output", help="Markdown page to write")
    options = parser.parse_args()
    folder = pathlib.Path(options.folder or SOURCE / f"build/studies/blind-{options.seed}").resolve()
    make(folder, options.cases, options.seed)
    run(folder, options)
    table = folder / "score.md"
    umov("blind", "score", folder / "cases", "--truth", folder / "sealed", "-o", table)
    sections = table.read_text(encoding="utf-8").rstrip().split("\n")
    if options.left_out:
        place = next((i for i, line in enumerate(sections) if line == "## By effect"), len(sections))
        sections[place:place] = left_out_section(*left_out_rows(folder, options), options)
    text = "\n".join(page(folder, options, sections)).rstrip() + "\n"
    if options.output:
        pathlib.Path(options.output).write_text(text, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
