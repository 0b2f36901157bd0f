"""One plan by the engines that people have, with one SHA-256; and espalier.Model under optimizers and samplers.

The stage `sweep` of `./dev test --all` installs the engines. Without an engine its test is skipped."""

import hashlib
import importlib
import importlib.util
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any, List

from support import GALLERY, REPOSITORY, espalier, program, variables

import espalier as package

CHAPTER = GALLERY / "chapter-sensitivity"
IS_LONG = os.environ.get("ESPALIER_LONG_TESTS") == "yes"
MEASURES = {"f": {"variable": "f"}}


def needs(*names: str) -> Any:
    """Skips a test without the programs (lower case) or modules (`module:NAME`)."""
    missing = [name for name in names
               if (importlib.util.find_spec(name[7:]) is None if name.startswith("module:") else shutil.which(name) is None)]
    return unittest.skipIf(not IS_LONG or bool(missing),
                           f"not installed: {', '.join(missing)}" if missing else "takes long: ./dev test --all sweep")


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def example(language: str, word: str) -> str:
    """The code block of docs/sweeps.md in that language with that word."""
    text = (REPOSITORY / "docs" / "sweeps.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```(\w*)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    (found,) = [block for kind, block in blocks if kind == language and word in block]
    return str(found)


class Engines(unittest.TestCase):
    expected = ""

    @classmethod
    def setUpClass(cls) -> None:
        if IS_LONG:
            with tempfile.TemporaryDirectory() as folder:
                espalier("sweep", str(CHAPTER / "calibration.json"), "-o", f"{folder}/r.sqlite", "--quiet")
                cls.expected = cls.hash_of(f"{folder}/r.sqlite")

    def setUp(self) -> None:
        self.folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder, True)
        for name in ("tree.l", "calibration.json"):
            shutil.copy(CHAPTER / name, self.folder)
        (self.folder / "calibration.json").rename(self.folder / "plan.json")
        # the commands of the page find the program
        bin_folder = self.folder / "bin"
        bin_folder.mkdir()
        (bin_folder / "espalier").symlink_to(program())
        self.environment = variables(PATH=f"{bin_folder}:{os.environ['PATH']}")

    @staticmethod
    def hash_of(results: str) -> str:
        return hashlib.sha256(espalier("sweep", "export", results).stdout.encode()).hexdigest()

    def shell(self, command: str) -> str:
        done = subprocess.run(["bash", "-c", command], cwd=self.folder, env=self.environment, capture_output=True, text=True,
                              timeout=300, stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, done.stderr[-3000:])
        return done.stdout

    def check(self) -> None:
        self.assertEqual(self.hash_of(str(self.folder / "results.sqlite")), self.expected)

    @needs("parallel")
    def test_long_gnu_parallel(self) -> None:
        self.shell(example("", "parallel -j 8").replace("-j 8", "-j 2").replace("64", "7") +
                   "\nespalier sweep merge part-*.sqlite -o results.sqlite")
        self.check()

    @needs("snakemake")
    def test_long_snakemake(self) -> None:
        (self.folder / "Snakefile").write_text(example("", "rule part").replace("N = 64", "N = 5"), encoding="utf-8")
        self.shell("snakemake -c2 --quiet --nocolor")
        self.check()
        self.assertEqual(hashlib.sha256((self.folder / "results.csv").read_bytes()).hexdigest(), self.expected)

    @needs("module:distributed")
    def test_long_dask(self) -> None:
        distributed: Any = importlib.import_module("distributed")
        os.environ["PYTHONPATH"] = self.environment["PYTHONPATH"]
        with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None,
                                      host="127.0.0.1") as cluster, distributed.Client(cluster) as client:
            parts = package.sweep.submit(self.folder / "plan.json", client, slices=5, program=program())
            package.sweep.gather(parts, self.folder / "results.sqlite", program=program())
            self.check()
            with package.Model(CHAPTER / "ishigami.l", parameters=["x", "y", "z"], measures=MEASURES) as alone, \
                    package.Model(CHAPTER / "ishigami.l", parameters=["x", "y", "z"], measures=MEASURES,
                                  client=client) as spread:
                rows = [[0.1 * i, 0.2, 0.3] for i in range(50)]
                self.assertEqual(spread.run(rows).tolist(), alone.run(rows).tolist())
        if importlib.util.find_spec("xarray"):
            data = package.sweep.dataset(self.folder / "results.sqlite", program=program())
            self.assertEqual(data.sizes["run"], 16384)
            self.assertEqual(int(data["all"].isnull().sum()), 0)

    @needs("slurmctld", "slurmd", "munged", "sbatch")
    def test_long_slurm(self) -> None:
        self.start_slurm()
        # the cluster allows 4 jobs in an array, so that 10 slices are three arrays
        jobs = self.shell("espalier sweep plan.json -o results.sqlite --slurm --slices 10 --job-option=--time=10").split()
        self.assertEqual(len(jobs), 4)
        end = time.monotonic() + 240
        while self.shell("squeue -h -o %i"):
            if time.monotonic() > end:
                self.fail(self.shell("squeue; sinfo -R; tail -n 30 results*.log slurm/*.log; true"))
            time.sleep(0.5)
        if not (self.folder / "results.sqlite").exists():
            self.fail(self.shell("tail -n 20 results*.log slurm/*.log; true"))
        self.check()

    def start_slurm(self) -> None:
        if os.geteuid() != 0:
            self.skipTest("Slurm's programs need root")
        folder = self.folder / "slurm"
        folder.mkdir(mode=0o755)
        self.folder.chmod(0o755)
        host = socket.gethostname().split(".")[0]
        (folder / "munge.key").write_bytes(os.urandom(64))
        (folder / "munge.key").chmod(0o600)
        (folder / "slurm.conf").write_text(f"""ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={free_port()}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MaxArraySize=5
MailProg=/bin/true
ReturnToService=2
SchedulerParameters=sched_interval=1,bf_interval=1
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
NodeName={host} NodeAddr=127.0.0.1 Port={free_port()} CPUs={os.cpu_count()} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
""", encoding="utf-8")
        for name in ("state", "spool"):
            (folder / name).mkdir()
        self.environment["SLURM_CONF"] = str(folder / "slurm.conf")
        commands: List[List[str]] = [
            ["munged", "--foreground", "--force", f"--key-file={folder}/munge.key", f"--socket={folder}/munge.socket",
             f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.log", f"--seed-file={folder}/munged.seed"],
            ["slurmctld", "-D"], ["slurmd", "-D", "-N", host]]
        for command in commands:
            with open(folder / f"{command[0]}.out.log", "wb") as output:
                process = subprocess.Popen(command, env=self.environment, stdout=output, stderr=output,
                                           stdin=subprocess.DEVNULL)
            self.addCleanup(process.wait)
            self.addCleanup(process.terminate)
            end = time.monotonic() + 30
            while command[0] == "munged" and not (folder / "munge.socket").exists():
                self.assertLess(time.monotonic(), end)
                time.sleep(0.05)
        end = time.monotonic() + 60
        while True:
            done = subprocess.run(["sinfo", "-h", "-o", "%T"], env=self.environment, capture_output=True, text=True)
            if done.stdout.strip() == "idle":
                return
            if time.monotonic() > end:
                self.fail(done.stdout + done.stderr + self.shell("tail -n 30 slurm/*.log; true"))
            time.sleep(0.2)


class Optimizers(unittest.TestCase):
    """espalier.Model, unchanged, under programs that bring the method."""

    def model(self) -> package.Model:
        made = package.Model(CHAPTER / "ishigami.l", parameters=["x", "y", "z"], measures=MEASURES, program=program())
        self.addCleanup(made.close)
        return made

    @needs("module:scipy")
    def test_long_scipy(self) -> None:
        optimize: Any = importlib.import_module("scipy.optimize")
        qmc: Any = importlib.import_module("scipy.stats.qmc")
        # the least value of Ishigami's function is that of x = -pi/2, y = 0, z = +-pi: -1 - pi^4 / 10
        found = optimize.minimize(self.model(), [-1.0, 0.3, 2.5], method="L-BFGS-B", bounds=3 * [(-3.14159265, 3.14159265)])
        self.assertAlmostEqual(found.fun, -1 - 3.14159265 ** 4 / 10, places=5)
        # the points of the design sobol are those of SciPy, up to half a cell
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "m.l").write_text("Lsystem: 1\nderivation length: 0\nStart: { " +
                                           " ".join(f"x{i} = 0;" for i in range(100)) + " }\nAxiom: F\nendlsystem\n",
                                           encoding="utf-8")
            parameters = ",".join(f'"x{i}":{{"uniform":[0,1]}}' for i in range(100))
            Path(folder, "plan.json").write_text(
                f'{{"model":"m.l","parameters":{{{parameters}}},"runs":{{"design":"sobol","count":256}},'
                '"measures":{"n":{"count":"F"}}}', encoding="utf-8")
            lines = espalier("sweep", f"{folder}/plan.json", "--table").stdout.splitlines()[1:]
        ours = [[float(cell) for cell in line.split(",")[2:]] for line in lines]
        theirs = qmc.Sobol(100, scramble=False).random(256)
        self.assertLess(abs(theirs - ours).max(), 1e-9)

    @needs("module:openturns")
    def test_long_openturns(self) -> None:
        ot: Any = importlib.import_module("openturns")
        model = self.model()

        class Function(ot.OpenTURNSPythonFunction):  # type: ignore[misc,name-defined]
            def __init__(self) -> None:
                super().__init__(3, 1)

            def _exec(self, x: Any) -> Any:
                return [model(list(x))]

            def _exec_sample(self, x: Any) -> Any:
                return model.run(list(map(list, x))).tolist()

        uniform = ot.ComposedDistribution(3 * [ot.Uniform(-3.141592653589793, 3.141592653589793)])
        experiment = ot.SobolIndicesExperiment(uniform, 4096, False).generate()
        values = ot.Function(Function())(experiment)
        indices = ot.SaltelliSensitivityAlgorithm(experiment, values, 4096)
        for found, exact in zip(indices.getFirstOrderIndices(), [0.3139, 0.4424, 0.0]):
            self.assertLess(abs(found - exact), 0.1)

    @needs("module:optuna")
    def test_long_optuna(self) -> None:
        optuna: Any = importlib.import_module("optuna")
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        model = self.model()
        study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=1))
        study.optimize(lambda trial: model([trial.suggest_float(name, -3, 3) for name in "xyz"]), n_trials=200)
        self.assertLess(study.best_value, -5.0)

    @needs("module:emcee")
    def test_long_emcee(self) -> None:
        emcee: Any = importlib.import_module("emcee")
        numpy: Any = importlib.import_module("numpy")
        # the length of internodes and their spread from the lengths of one tree: normal logarithms
        measures = {"n": {"count": "I"}, "sum": {"sum": "log(l/0.7^o)", "of": "I(o,l)"},
                    "squares": {"sum": "log(l/0.7^o)^2", "of": "I(o,l)"}}
        with package.Model(CHAPTER / "tree.l", parameters=["length", "spread"], measures=measures,
                           program=program()) as model:
            n, total, squares = model.run([[2.0, 0.3]], seeds=[9])[0]

            def likelihood(theta: Any) -> float:
                mean, deviation = theta
                if not 0.05 < deviation < 2:
                    return -numpy.inf
                return float(-n * numpy.log(deviation) - (squares - 2 * mean * total + n * mean * mean) / (2 * deviation ** 2))

            state = numpy.random.RandomState(3)
            sampler = emcee.EnsembleSampler(16, 2, likelihood)
            sampler._random = state
            sampler.run_mcmc(numpy.column_stack([state.normal(0.6, 0.01, 16), state.normal(0.4, 0.01, 16)]), 600)
            chain = sampler.get_chain(discard=200, flat=True)
            self.assertGreater(n, 50)
            self.assertLess(abs(chain[:, 0].mean() - numpy.log(2.0)), 4 * 0.3 / n ** 0.5)
            self.assertLess(abs(chain[:, 1].mean() - 0.3), 0.1)
            # the posterior foretells the length of other trees
            rows = numpy.column_stack([numpy.exp(chain[::200, 0]), chain[::200, 1]])
            self.assertTrue(numpy.isfinite(model.run(rows, seeds=numpy.arange(len(rows)))).all())


if __name__ == "__main__":
    sys.exit(unittest.main())
