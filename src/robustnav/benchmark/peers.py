"""The peer libraries by name; all belong to the optional extra ``peers`` and load when they are used."""

from __future__ import annotations

from robustnav.benchmark import peer_imufusion, peer_vqf
from robustnav.benchmark.peer import Peer, load

PEERS: dict[str, Peer] = {peer.name: peer for peer in (*peer_vqf.PEERS, *peer_imufusion.PEERS)}


def installed_peers() -> tuple[str, ...]:
    """Return the names of the peers that can run here."""
    return tuple(name for name, peer in PEERS.items() if load(peer.module) is not None)


def missing_peers() -> tuple[str, ...]:
    """Return the names of the peers whose library is not installed."""
    present = installed_peers()
    return tuple(name for name in PEERS if name not in present)
