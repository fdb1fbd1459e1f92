"""A running server, as `bake` and `hero` talk to it."""

from __future__ import annotations

import json
import urllib.error
import urllib.request
from pathlib import Path

BOUNDARY = "toile-outfit-file"


class Service:
    """An outfit at a running server."""

    def __init__(self, server: str, outfit: str) -> None:
        self.outfit = outfit
        self.address = f"{server.rstrip('/')}/v1/outfits/{outfit}"

    @classmethod
    def of(cls, server: str, outfit: str) -> Service:
        """An outfit by its id, or by a file, which is uploaded."""
        path = Path(outfit)
        if path.suffix and not path.is_file():
            raise SystemExit(f"There is no file {outfit}.")
        if not path.suffix:
            return cls(server, outfit)
        head = f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="file"; filename="{path.name}"\r\n\r\n'
        body = head.encode() + path.read_bytes() + f"\r\n--{BOUNDARY}--\r\n".encode()
        kind = {"Content-Type": f"multipart/form-data; boundary={BOUNDARY}"}
        answer = asked(urllib.request.Request(f"{server.rstrip('/')}/v1/outfits", body, kind, method="POST"))
        return cls(server, json.loads(answer)["id"])

    def ask(self, method: str, path: str, body: bytes | None = None) -> bytes:
        """Its answer, or its complaint as the end of the program."""
        return asked(urllib.request.Request(f"{self.address}/{path}", body, method=method))


def asked(request: urllib.request.Request) -> bytes:
    """The answer to a request, or the server's complaint as the end of the program."""
    try:
        with urllib.request.urlopen(request) as answer:
            return answer.read()
    except urllib.error.HTTPError as error:
        raise SystemExit(json.loads(error.read())["detail"]) from error
    except urllib.error.URLError as error:
        where = f"{request.full_url}: {error.reason}"
        raise SystemExit(f"No server answers at {where}. Start one with `make run`.") from error
