"""What a person sees on the terminal: short text, help, advice on wrong names, options from a file, completions, manual page.

Usage: terminal_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
"""
import re
import shutil
import subprocess
import sys
import unittest

from command_line import CliTest, PATCHWRIGHT, run, SAMPLES, WING

CUBE = SAMPLES / "cages" / "cube.obj"
COMMANDS = ("convert", "cage", "fit", "refit", "family", "member", "morph", "export", "compare", "inspect", "grid", "eval", "subdivide")


class Text(CliTest):
    def test_fifteen_lines_and_all_of_them_with_verbose(self):
        step = self.path("a.step")
        for arguments in (["convert", WING / "wing.igs", "--cage", WING / "wing_cage.obj", "-o", step, "--tolerance", "1e-3rel"],
                          ["compare", WING / "wing.igs", step, "--tolerance", "1e-8rel"], ["inspect", WING / "wing.igs"],
                          ["export", CUBE, "-o", self.path("b.step")],
                          ["grid", CUBE, "-o", self.path("b.cgns"), "--layers", 3, "--layer-height", "1e-3rel"]):
            with self.subTest(arguments[0]):
                brief = run(*arguments).stdout.splitlines()
                full = run(*arguments, "-v").stdout.splitlines()
                self.assertLessEqual(len(brief), 15)
                self.assertGreater(len(full), len(brief))
                if arguments[0] != "inspect":
                    self.assertEqual({brief[0], brief[-1]}, {full[0], full[-1]})
                    self.assertRegex(brief[0], "^(met|MISSED)")
                    self.assertEqual(brief[0], brief[-1])

    def test_progress_keeps_notices_on_lines_of_their_own(self):
        result = subprocess.run([PATCHWRIGHT, "inspect", WING / "wing.igs", "--progress"], capture_output=True, timeout=60)
        text = result.stderr.decode()
        shown = "".join(re.split(r"[^\n]*\r\033\[K", text))  # what erasing leaves
        self.assertEqual(shown, "note: 4 faces turned to agree with their neighbours and to look outward\n")
        self.assertRegex(text, r"\d+ % +\d+\.\d s")

    def test_an_error_takes_the_place_of_progress(self):
        cut = self.path("cut.igs", (WING / "wing.igs").read_text()[:4000])
        result = subprocess.run([PATCHWRIGHT, "inspect", cut, "--progress"], capture_output=True, timeout=60)
        text = result.stderr.decode()
        self.assertEqual(result.returncode, 2)
        self.assertIn(" % ", text)
        self.assertRegex("".join(re.split(r"[^\n]*\r\033\[K", text)), r"^patchwright: [^\n]*\n$")


class Help(CliTest):
    def test_every_option_is_in_a_group_and_every_command_has_an_example(self):
        for command in COMMANDS:
            with self.subTest(command):
                text = run("help", command).stdout
                self.assertEqual(text, run(command, "--help").stdout)
                self.assertNotIn("\nOptions:", text)  # what no group was given
                self.assertNotIn(" TEXT", text)
                self.assertIn(f"Examples:\n  patchwright {command} ", text)
                self.assertIn(f"below [{command}]: --config FILE.toml", text)
        self.assertEqual(run("help").stdout, run("--help").stdout)
        for command in COMMANDS:
            self.assertIn(f"\n  {command} ", run("help").stdout)

    def test_version_everywhere(self):
        for command in COMMANDS:
            self.assertEqual(run(command, "--version").stdout, run("--version").stdout)

    def test_advice(self):
        for arguments, advice in ((["convertt"], "did you mean convert?"), (["help", "grit"], "did you mean grid?"),
                                  (["convert", "a.igs", "--tolerence", "1mm"], "did you mean --tolerance?"),
                                  (["grid", "a.obj", "--frist-cell=1mm"], "did you mean --first-cell?"),
                                  (["xyzzy"], "no subcommand 'xyzzy'; see --help"),
                                  (["compare", "a", "b", "--tolerance", "0.1"], "add a unit: 0.1mm")):
            with self.subTest(arguments):
                self.check_error(run(*arguments), 1, advice)
        for length in ("0.1 mm", "0.004 inch", "0.004inches", "1 feet"):
            self.assertEqual(run("compare", WING / "wing.step", WING / "wing.step", "--tolerance", length).returncode, 0, length)


class Config(CliTest):
    def test_options_from_a_file_and_in_the_report(self):
        file = self.path("c.toml", "[export]\nunit = \"m\"\npatches = \"faces\"\n[grid]\npoints = 5\n")
        options = lambda *more: self.report("export", CUBE, "-o", self.path("a.step"), "--config", file, *more)["options"]
        found = options("--unit", "cm")
        self.assertEqual((found["unit"], found["patches"], found["continuity"]), ("cm", "faces", "g1"))
        self.assertEqual(options()["unit"], "m")
        wrong = self.path("w.toml", "[export]\nunits = \"m\"\n")
        self.check_error(run("export", CUBE, "-o", self.path("a.step"), "--config", wrong), 1, "export.units")
        self.check_error(run("export", CUBE, "-o", self.path("a.step"), "--config", self.path("none.toml")), 1, "none.toml")
        for text, advice in (("[export]\nunits = \"m\"\n", "export has no option --units (did you mean --unit?)"),
                             ("unit = \"m\"\n", "--config: unit: options stand below a line with their subcommand: [export]"),
                             ("[exprot]\nunit = \"m\"\n", "no subcommand 'exprot' (did you mean export?)")):
            with self.subTest(text):
                self.check_error(run("export", CUBE, "-o", self.path("a.step"), "--config", self.path("w.toml", text)), 1, advice)
        bad = self.path("b.toml", "[export]\nunit = \"furlong\"\n")
        self.check_error(run("export", CUBE, "-o", self.path("a.step"), "--config", bad), 1, "furlong")


class Generated(CliTest):
    def script(self, shell):
        text = run("completion", shell).stdout
        return self.path(f"completion.{shell}", text)

    def test_bash_completes(self):
        script = self.script("bash")
        self.path("wing.step", "")

        def completed(*words):
            program = f'source {script}; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _patchwright; echo "${{COMPREPLY[@]}}"'
            result = subprocess.run(["bash", "-c", program, "-", "patchwright", *words], capture_output=True, text=True, cwd=self.folder)
            self.assertEqual(result.stderr, "")
            return result.stdout.split()

        self.assertEqual(completed("comp"), ["compare", "completion"])
        self.assertEqual(completed("convert", "--tol"), ["--tolerance"])
        self.assertEqual(completed("convert", "--layout", ""), ["aligned", "remesh", "auto"])
        self.assertEqual(completed("convert", "w"), ["wing.step"])
        self.assertEqual(completed("convert", "--json", "w"), ["wing.step"])
        self.assertEqual(completed("convert", "--samples", ""), [])  # a number is no file
        self.assertEqual(completed("grid", "-n", "w"), ["wing.step"])
        self.assertEqual(completed("convert", "--conf"), ["--config"])
        self.assertEqual(completed("convert", "--unit", "i"), ["in", "input"])
        self.assertEqual(completed("help", "gr"), ["grid"])

    def test_other_shells_can_read_theirs(self):
        for shell in ("zsh", "fish"):
            script = self.script(shell)
            for command in COMMANDS:
                self.assertIn(command, script.read_text())
            if shutil.which(shell):
                result = subprocess.run([shell, "-n", script], capture_output=True, text=True)
                self.assertEqual((result.returncode, result.stderr), (0, ""))

    def test_manual(self):
        page = run("man").stdout
        for option in ("--config", "--version"):
            self.assertIn(option.replace("-", "\\-"), page)
        for command in COMMANDS:
            self.assertIn(f".SS {command}\n", page)
            for option in re.findall(r"--[a-z0-9-]+", run("help", command).stdout.split("Examples:")[0]):
                self.assertIn(option.replace("-", "\\-"), page)
        if shutil.which("groff"):
            result = subprocess.run(["groff", "-man", "-Tutf8", "-ww"], input=page, capture_output=True, text=True)
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            self.assertIn("--tolerance", re.sub("\x1b\\[[0-9;]*m", "", result.stdout))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
