"""Progress bar."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from typing import Callable, Iterator, Optional

from .optional import needed


@contextmanager
def bar(wanted: Optional[bool]) -> Iterator[Optional[Callable[[float], None]]]:
    """Progress callback with a fraction from 0 to 1; None without a bar. Default: a bar in notebooks with tqdm."""
    if wanted is None:
        wanted = "ipykernel" in sys.modules and "tqdm" in sys.modules
    if not wanted:
        yield None
        return
    with needed("tqdm.auto").tqdm(total=100, unit="%", leave=False) as shown:

        def tell(share: float) -> None:
            shown.update(100.0 * share - shown.n)

        yield tell
