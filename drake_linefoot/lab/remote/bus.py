"""Messages over Drake's LCM: only the newest of a kind counts."""

from typing import Any

from pydrake.lcm import DrakeLcm

from drake_linefoot.lab.remote.messages import KINDS, Kind, decode, encode

# The network of LCM; with a time to live of 0 nothing leaves this computer.
URL = "udpm://239.255.76.67:7667?ttl=0"
_CHANNELS = {kind: channel for channel, kind in KINDS.items()}


class Bus:
    """Publishes messages, and keeps the newest of each kind that is asked for.

    A queue of states would be fatal: the answers would come later and later.

    Attributes:
        damaged: how many messages could not be opened.
    """

    def __init__(self, *kinds: type[Any], url: str = URL) -> None:
        """Listen to messages of `kinds`; `url` is that of LCM."""
        self.damaged, self._newest = 0, dict[type[Any], bytes]()
        self._lcm = DrakeLcm(url)
        for kind in kinds:
            self._lcm.Subscribe(_CHANNELS[kind], self._keeper(kind))

    def publish(self, message: tuple[Any, ...]) -> None:
        """Send a message to whoever listens."""
        self._lcm.Publish(_CHANNELS[type(message)], encode(message))

    def wait(self, timeout: float) -> None:
        """Take in all that has come, and before that wait up to `timeout` [s] if nothing has."""
        count = self._lcm.HandleSubscriptions(round(1e3 * timeout))
        while count:
            count = self._lcm.HandleSubscriptions(0)

    def take(self, kind: type[Kind]) -> Kind | None:
        """Return the newest message of a kind since the last call; None when there is none."""
        data = self._newest.pop(kind, None)
        if data is None:
            return None
        try:
            return decode(kind, data)
        except ValueError:
            self.damaged += 1
            return None

    def _keeper(self, kind: type[Any]) -> Any:
        newest = self._newest

        def keep(data: bytes) -> None:
            newest[kind] = data

        return keep
