"""The examples of samples/python, as users run them, and what they say against what is known otherwise."""
import importlib.util
import re
import shutil
import subprocess
import sys

from module import SAMPLES, ModuleTest, main, np, pw

EXAMPLES = SAMPLES / "python"


def needs(test, module):
    if importlib.util.find_spec(module) is None:
        test.skipTest(f"SKIPPED: no {module}")


class Samples(ModuleTest):
    def run_example(self, *arguments):
        done = subprocess.run([sys.executable, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_the_document(self):
        section = (SAMPLES / "README.md").read_text().split("### Python\n")[1].split("\n### ")[0]
        code = re.search("```python\n(.*?)```", section, re.DOTALL)[1]
        shutil.copy(SAMPLES / "wing" / "wing.igs", self.folder)
        (self.folder / "example.py").write_text(code)
        self.assertIn("met 1e-4: one closed valid solid", self.run_example("example.py"))
        larger, wing = (pw.inspect(self.folder / f"{n}.step").report["solid"]["volume"] for n in ("larger", "wing"))
        self.assertAlmostEqual(larger * 25.4**-3 / wing, 1.1**3, places=3)  # mm, and the inches of the input

    def test_round_trip(self):
        needs(self, "pytest")
        text = self.run_example("-m", "pytest", "-q", "-p", "no:cacheprovider", EXAMPLES / "test_round_trip.py")
        self.assertIn("4 passed", text)

    def test_design_sweep(self):
        rows = self.run_example(EXAMPLES / "design_sweep.py", "designs").splitlines()[1:]
        self.assertEqual(len(rows), 3)
        figures = [row.split() for row in rows]
        for angle, solid, limit, patches, verdict in figures:
            self.assertEqual(verdict, "met")
            # Exact but at extraordinary vertices; a shear keeps the volume.
            self.assertAlmostEqual(float(solid) / float(limit), 1, places=4)
            self.assertAlmostEqual(float(limit) / float(figures[0][2]), 1, places=5)
        self.assertEqual([f[0] for f in figures], ["0.0", "5.0", "10.0"])
        self.assertEqual(len(list((self.folder / "designs").glob("*.step"))), 3)

    def test_deviation_plot(self):
        needs(self, "matplotlib")
        text = self.run_example(EXAMPLES / "deviation_plot.py", "plot.png")
        largest = float(re.search(r"largest ([\d.e-]+) mm", text)[1])
        self.assertLess(largest, 1e-4 * pw.read(SAMPLES / "wing" / "wing.igs").diagonal)
        import matplotlib.image
        picture = matplotlib.image.imread(self.folder / "plot.png")
        self.assertGreater(len(np.unique(picture.reshape(-1, picture.shape[-1]), axis=0)), 100)


if __name__ == "__main__":
    main()
