"""The examples of the pages about Python run as they stand; the types of requests are current."""
import contextlib
import io
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from support import EXAMPLES, SOURCE


class Page(unittest.TestCase):
    def test_the_examples_run_in_order(self):
        for name, least in (("python", 6), ("episodes", 2), ("teleoperation", 1)):
            with self.subTest(page=name):
                self.run_page(f"docs/{name}.md", least)

    def run_page(self, path, least):
        page = (SOURCE / path).read_text()
        blocks = [(page[:found.start()].count("\n") + 1, found.group(1))
                  for found in re.finditer(r"^```python\n(.*?)^```", page, re.M | re.S)]
        self.assertGreaterEqual(len(blocks), least)
        here = os.getcwd()
        folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, folder)
        self.addCleanup(os.chdir, here)
        shutil.copytree(EXAMPLES, folder / "examples")
        os.chdir(folder)
        names = {}
        for line, code in blocks:
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile("\n" * line + code, path, "exec"), names)

    def test_the_requests_are_those_of_the_protocol(self):
        done = subprocess.run([sys.executable, SOURCE / "python/make_requests", "--check"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_the_stubs_have_every_public_name_of_the_module(self):
        import ast

        import polyarm
        stub = ast.parse((SOURCE / "python/polyarm/__init__.pyi").read_text())
        for node in stub.body:
            if isinstance(node, ast.ClassDef) and node.name in polyarm.__all__:
                declared = {each.name for each in node.body if isinstance(each, ast.FunctionDef)}
                there = {name for name in vars(getattr(polyarm, node.name)) if not name.startswith("_")}
                self.assertEqual({name for name in declared if not name.startswith("_")}, there, node.name)
        names = {getattr(node, "name", "") for node in stub.body}
        self.assertLessEqual(set(polyarm.__all__) - {"Error"}, names)

    @unittest.skipUnless(shutil.which("mypy"), "mypy is not installed")
    def test_types_agree(self):
        done = subprocess.run(["mypy", "--cache-dir", "/dev/null", "--strict", "--no-warn-return-any", "--follow-imports=silent", "client.py", "requests.py"],
                              cwd=SOURCE / "python/polyarm", capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main()
