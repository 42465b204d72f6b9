"""The cores that costs are stated for, and the emulator's boards that have them."""

from __future__ import annotations

from dataclasses import dataclass

_HARD = "-mthumb -mfloat-abi=hard -mfpu="


@dataclass(frozen=True)
class Board:
    """One emulated board: its name in the emulator, compiler flags, where its memories begin and how long they are."""

    machine: str
    flags: str
    rom: str = "0"
    rom_length: str = "0x100000"
    ram: str = "0x20000000"
    ram_length: str = "0x40000"

    @property
    def double(self) -> bool:
        """Whether the core computes in double by itself."""
        return self.flags.endswith("fpv5-d16")

    @property
    def single(self) -> bool:
        """Whether the core computes in float by itself."""
        return _HARD in self.flags


BOARDS = {
    "m0+": Board("microbit", "-mcpu=cortex-m0plus -mthumb -mfloat-abi=soft", rom_length="0x40000", ram_length="0x4000"),
    "m3": Board("mps2-an385", "-mcpu=cortex-m3 -mthumb -mfloat-abi=soft"),
    "m4f": Board("mps2-an386", f"-mcpu=cortex-m4 {_HARD}fpv4-sp-d16"),
    "m7": Board("mps2-an500", f"-mcpu=cortex-m7 {_HARD}fpv5-sp-d16"),
    "m33": Board(
        "mps2-an505", f"-mcpu=cortex-m33 {_HARD}fpv5-sp-d16", rom="0x10000000", ram="0x38000000", ram_length="0x40000"
    ),
}
