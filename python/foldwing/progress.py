"""A bar for runs that last."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from typing import Callable, Iterator, Optional

from .optional import needed


@contextmanager
def bar(wanted: Optional[bool]) -> Iterator[Optional[Callable[[float], None]]]:
    """What a run tells its share to, from 0 to 1; nothing unless a bar is wanted, by default in notebooks that have tqdm."""
    if wanted is None:
        wanted = "ipykernel" in sys.modules and "tqdm" in sys.modules
    if not wanted:
        yield None
        return
    with needed("tqdm.auto").tqdm(total=100, unit="%", leave=False) as shown:

        def tell(share: float) -> None:
            shown.update(100.0 * share - shown.n)

        yield tell
