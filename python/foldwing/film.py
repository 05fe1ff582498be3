"""Videos of runs as files, which notebooks can play."""

from __future__ import annotations

import base64
import os
import tempfile
from pathlib import Path
from typing import Any, Dict, Optional, Sequence, Tuple, Union

from . import _native
from .progress import bar


class Video:
    """A video of a run; notebooks play it in the cell."""

    def __init__(self, summary: Dict[str, Any]) -> None:
        self.files = [Path(file) for file in summary["files"]]
        """Written files: one, or one for each frame."""
        self.frames: int = summary["frames"]
        """Number of frames."""
        self.frames_per_s: float = summary["frames_per_s"]
        """Frames per second."""
        self.size: Tuple[int, int] = (summary["width"], summary["height"])
        """Width and height in pixels."""
        self.speed: float = summary["speed"]
        """Seconds of the run per second of the video."""
        self.camera: str = summary["camera"]
        """`follow` or `fixed`."""
        self.span: Tuple[float, float] = (summary["from_s"], summary["to_s"])
        """First and last time of the run in s."""

    @property
    def path(self) -> Path:
        """The file; the first of numbered files."""
        return self.files[0]

    @property
    def length(self) -> float:
        """Length in s."""
        return self.frames / self.frames_per_s

    def __repr__(self) -> str:
        width, height = self.size
        return f"<foldwing.Video {self.path}: {self.frames} frames of {width}x{height}, {self.length:.2f} s, speed {self.speed:g}, camera {self.camera}>"

    def _repr_html_(self) -> str:
        data = base64.b64encode(self.path.read_bytes()).decode()
        if self.path.suffix.lower() in (".mp4", ".m4v"):
            return f'<video controls loop autoplay muted playsinline style="max-width:100%" src="data:video/mp4;base64,{data}"></video>'
        kind = self.path.suffix.lower().lstrip(".")
        return f'<img style="max-width:100%" src="data:image/{kind};base64,{data}">'


def write(
    page: str,
    output: Union[None, str, os.PathLike[str]],
    size: Optional[Tuple[int, int]],
    fps: Optional[float],
    speed: Optional[float],
    camera: Union[str, Sequence[str]],
    span: Tuple[Optional[float], Optional[float]],
    force: bool,
    progress: Optional[bool],
) -> Video:
    """Write a video of the run in a page; arguments as in `Result.video`."""
    file = Path(output) if output is not None else Path(tempfile.mkdtemp(prefix="foldwing-")) / "run.mp4"
    words = camera.split(",") if isinstance(camera, str) else list(camera)
    chosen = [word.strip() for word in words if word.strip()]
    with bar(progress) as tell:
        return Video(_native.film(page, os.fspath(file), size, fps, speed, chosen, span, force, tell))
