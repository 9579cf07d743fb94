# The binding, for the modules of this package only: __init__.pyi has the types of what they make of it.
from typing import Any

def __getattr__(name: str) -> Any: ...
