"""Pages with animations: in a notebook, in the browser, as a file."""

from __future__ import annotations

import importlib
import os
import sys
import tempfile
import webbrowser
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Tuple, Union

from . import _native
from .errors import UsageError

if TYPE_CHECKING:
    from .model import Model


def show_page(page: str, name: str, output: Union[None, str, os.PathLike[str]], show: bool) -> Any:
    """Write a page and show it; `name` is the name of a temporary file. Returns the displayed HTML object in notebooks, otherwise the
    path."""
    file = Path(output) if output is not None else Path(tempfile.mkdtemp(prefix="foldwing-")) / name
    _native.write_page(page, os.fspath(file), False)
    if not show:
        return file
    if "ipykernel" in sys.modules:
        display: Any = importlib.import_module("IPython.display")
        return display.HTML(f'<iframe srcdoc="{escape(page)}" width="100%" height="600" style="border:0"></iframe>')
    webbrowser.open(file.resolve().as_uri())
    return file


class Shapes:
    """Results with mode shapes that can be animated."""

    _source: Optional[Tuple[Model, str, Tuple[Any, ...]]] = None

    def page(self) -> str:
        """Page with the animated mode shapes, as HTML. The analysis is repeated with the same arguments.

        Raises:
            StaticsError: if there are no modes to draw.
            UsageError: if the result is one of `Model.flutter_map`, or was not created by a model.
        """
        if self._source is None:
            raise UsageError("no page: this result does not contain its model; call Model.modes, Model.flutter or Model.periodic")
        model, method, arguments = self._source
        page: str = getattr(model._native, method)(*arguments)
        return page

    def view(self, output: Union[None, str, os.PathLike[str]] = None, *, show: bool = True) -> Any:
        """Animate the mode shapes: in a notebook as the output of the cell, otherwise in the browser. The analysis is repeated.

        Args:
            output: HTML file to write; default: a temporary file.
            show: if false, only write the file.

        Returns:
            In notebooks the displayed HTML object, otherwise the path of the file.
        """
        return show_page(self.page(), "modes.html", output, show)
