# SPDX-License-Identifier: MIT
#
# peers_test.py REPOSITORY: the peers' script says which peers are absent and why, and downloads nothing when told not to.
import os
import sys
import tempfile
import types

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(sys.argv[1], "src/bench/peers"))
import peers  # noqa: E402

import motion  # noqa: E402

for name in ("casadi_chain.py", "heyoka_chain.py", "many.py", "many_heyoka.py", "motion_heyoka.py", "motion_scipy.py", "sensitivities.py",
             "sensitivities_casadi.py", "sensitivities_heyoka.py", "sensitivities_known.py"):
    with open(peers.source(name), encoding="utf-8") as file:
        compile(file.read(), name, "exec")

with tempfile.TemporaryDirectory() as work:
    options = types.SimpleNamespace(work=work, python=os.path.join(work, "venv/bin/python"), ceres=os.path.join(work, "nowhere"), eigen=work,
                                    compiler="no-such-compiler", flags="-O0", offline=True)

    def reason(peer):
        try:
            peer(options)
        except peers.Absent as absent:
            return str(absent)
        return "present"

    for peer in (peers.casadi, peers.pinocchio, peers.heyoka):
        assert reason(peer) == "not installed, and --offline", reason(peer)
    assert reason(peers.ceres) in ("not installed, and --offline", "no program no-such-compiler"), reason(peers.ceres)
    assert reason(peers.autodiff) == "neither pip nor apt has its headers"
    assert os.listdir(work) == [], os.listdir(work)

    # A program that fails is quoted; one that is missing is named.
    options.compiler = sys.executable
    assert reason(lambda _: peers.ran([sys.executable, "-c", "raise SystemExit('error: no luck')"], "does not build")) == \
        "does not build: error: no luck"
    assert reason(lambda _: peers.ran(["no-such-program"], "fails")) == "no program no-such-program"
    # Times come as lines.
    row = next(motion.parsed("chain 2;1e-09;taylor;1.0e-09;6.7e-10;42.50"))
    assert row["problem"] == "chain 2" and row["error"] == 1e-9 and row["method"] == "taylor" and row["microseconds"] == 42.5, row
    assert [motion.number(x) for x in (0.9, 12.34, 345.6)] == ["0.90", "12.3", "346"]
print("peers: absent ones are named")
