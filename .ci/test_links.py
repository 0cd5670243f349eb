"""links.py finds what is broken, and nothing else."""

import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

LINKS = Path(__file__).resolve().with_name("links.py")

GOOD = """# Title
## Some `code`, and more
## Twice
## Twice
[file](docs/page.md) [anchor](#some-code-and-more) [second](#twice-1) [folder](docs) ![picture](docs/it.png) [web](https://example.org/x)
`[code](nowhere.md)` [`around code`](docs/page.md#a-heading)
```sh
[in a block](nowhere.md)
```
"""


class LinksTest(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        for name, text in {
            "README.md": GOOD,
            "docs/page.md": "# A heading\n[up](../README.md#twice)\n",
            "docs/SUMMARY.md": "# Summary\n- [Page](page.md)\n",
            "docs/it.png": "picture",
        }.items():
            self.write(name, text)
        (self.folder / ".ci").mkdir()
        shutil.copy(LINKS, self.folder / ".ci/links.py")

    def write(self, name, text):
        file = self.folder / name
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")

    def check(self, *arguments):
        """The exit status, and the complaints."""
        for command in [["git", "init", "--quiet"], ["git", "add", "--all"]]:
            subprocess.run(command, cwd=self.folder, check=True)
        run = subprocess.run([sys.executable, ".ci/links.py", *arguments], cwd=self.folder, capture_output=True, text=True)
        return run.returncode, run.stderr.splitlines()

    def test_sound_documents_pass(self):
        self.assertEqual(self.check(), (0, []))

    def test_each_broken_link_fails_with_its_line(self):
        for link, problem in {
            "[a](docs/other.md)": "docs/other.md: there is no such file",
            "[a](docs/page.md#heading)": "docs/page.md#heading: page.md has no such heading",
            "[a](#twice-2)": "#twice-2: README.md has no such heading",
            "![a](docs/other.png)": "docs/other.png: there is no such file",
            "[a](docs/it.png#part)": "docs/it.png#part: an anchor in a file that is no document",
            "[a]: other.md": "other.md: there is no such file",
            '<img src="other.png">': "other.png: there is no such file",
        }.items():
            with self.subTest(link):
                self.write("README.md", GOOD + link + "\n")
                self.assertEqual(self.check(), (1, [f"README.md:10: {problem}"]))

    def test_a_document_that_the_book_lacks_fails(self):
        self.write("docs/new.md", "# New\n")
        self.assertEqual(self.check(), (1, ["docs/new.md: not in docs/SUMMARY.md"]))

    def test_a_broken_link_of_the_book_fails(self):
        self.write("book/index.html", '<h1 id="title"></h1><a href="#title"></a><a href="page.html"></a><img src="it.png">')
        self.write(".gitignore", "/book\n")
        status, complaints = self.check("--book", "book")
        self.assertEqual((status, len(complaints)), (1, 2), complaints)


if __name__ == "__main__":
    unittest.main()
