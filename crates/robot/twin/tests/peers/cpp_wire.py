"""The vendor's C++ SDK on the loopback. It knows domain 0 only; CycloneDDS below it can be set to pass for another one on the wire."""

import os
import sys

import unitree_interface as sdk

LOOPBACK = """<CycloneDDS><Domain Id="0"><General><AllowMulticast>false</AllowMulticast><Interfaces>
<NetworkInterface name="lo" multicast="false"/></Interfaces></General><Discovery><ExternalDomainId>{}</ExternalDomainId>
<ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"""


def open_g1(domain):
    os.environ.pop("CYCLONEDDS_URI", None)
    return sdk.UnitreeInterface.create_g1("lo", sdk.MessageType.HG, dds_config=LOOPBACK.format(domain))


def say(line):
    """Prints a line of its own in one write: the SDK prints too, and may be in the middle of a line."""
    sys.stdout.write(f"\n{line}\n")
    sys.stdout.flush()
