"""The figures of results/bench/summary.json, from what was measured."""
import chains
import exudyn_peer
import loops
import robots
from search import fastest, ratio


def summary(measured):
    """measured: what benchmarks.py collects. Keys of ratios are null without peers."""
    fixed, by_size, sizes = measured["fixed"], measured["by_size"], measured["sizes"]
    acceleration = measured["accelerations"]
    rows, loop_rows = measured["chain_rows"], measured["loop_rows"]

    def time_ratio(a, b):
        return fixed[a]["us_per_step"] / fixed[b]["us_per_step"]

    own = acceleration["spherical"]["1000"]
    by_hand = acceleration.get("hand-written", {}).get("1000")
    out = {
        "us_per_link_step": fixed["chain"]["us_per_step"] / 1000,
        "us_per_link_step_revolute": fixed["chain_revolute"]["us_per_step"] / 1000,
        "chain_over_limit": time_ratio("chain", "limit_chain"),
        "hinge_over_limit": time_ratio("chain_revolute", "limit_chain"),
        "bytes_per_link": measured["bytes_per_link"]["chain"],
        "chain_exponent": by_size["chain, spherical"]["exponent"],
        "chain_exponent_revolute": by_size["chain, revolute"]["exponent"],
        "chain_exponent_of_limit": by_size["hand-written chain, spherical"]["exponent"],
        "ladder_exponent": by_size["ladder"]["exponent"],
        "grid_exponent": by_size["grid"]["exponent"],
        "us_per_flexible_step": fixed["pendulum"]["us_per_step"],
        "flexible_over_limit": time_ratio("pendulum", "limit_flexible"),
        "flexible30_over_limit": time_ratio("pendulum_30", "limit_flexible_30"),
        "flexible_30_over_9": time_ratio("pendulum_30", "pendulum"),
        "flexible_4320_over_16_elements": time_ratio("pendulum_fine", "pendulum"),
        "us_per_beam_element_step": fixed["beam"]["us_per_step"] / 100,
        "beam_over_limit": time_ratio("beam", "limit_beam"),
        "beam_consistent_over_lumped": time_ratio("beam_consistent", "beam"),
        "cable_over_beam": time_ratio("cable", "beam"),
        "beam_exponent": by_size["beam"]["exponent"],
        "cable_exponent": by_size["cable"]["exponent"],
        "us_per_link_acceleration": own,
        "us_per_link_acceleration_revolute": acceleration["revolute"]["1000"],
        "acceleration_over_limit": own / by_hand if by_hand else None,
        "robots_over_best": robots.over_best(measured.get("robots", {})),
        "robots_compiled_over_best": robots.over_best(measured.get("robots", {}), "compiled"),
        "lanes8": robots.lanes8(measured.get("robots", {})),
    }
    for scene in ("chain", "flexible"):
        row = measured.get("threads", {}).get(scene, {})
        out[f"threads2_{scene}"] = row.get("times_faster")
        out[f"threads2_{scene}_by_machine"] = row.get("times_by_machine")
    out["ratio_exudyn"], out["ratios_exudyn"] = exudyn_peer.ratios(measured.get("exudyn", []))
    for target, name in zip(chains.TARGETS, ("1e4", "1e6")):
        found = chains.ratios(rows, sizes, target)
        out[f"ratio_fastest_peer_{name}"] = chains.least(found, [n for n in sizes if n > 16])
        out[f"ratio_n16_{name}"] = chains.least(found, [16])
        out[f"ratios_{name}"] = found

    def cheapest_ms(problem, target):
        found = fastest(loop_rows, target, True, problem=problem)
        if not found:
            return None
        row, run = found
        return {"ms": 1e3 * run["seconds"], "method": row["method"], "tol": run["setting"], "error": run["error"]}

    raw = measured["raw_andrews"]
    out |= {
        "andrews_6_digits": cheapest_ms("andrews", 1e-6),
        "andrews_10_digits": cheapest_ms("andrews", 1e-10),
        "andrews_raw_6_digits_ms": loops.raw_at(raw, 6),
        "andrews_raw_10_digits_ms": loops.raw_at(raw, 10),
        "four_bar_published": loops.four_bar_published(loop_rows),
        "governor_1e6": cheapest_ms("governor", 1e-6),
        "loop_ratios": {name: ratio(loop_rows, 1e-4, problem=name) for name in ("andrews", "four_bar", "bricard")},
        "stiff_chain_ratio": ratio(loop_rows, 1e-4, problem="stiff_chain"),
        "same_answer_m": measured["same_answers"],
        "quick": measured["quick"],
        "machine": measured["machine"],
        "accelerations": acceleration,
        "by_size": by_size,
        "fixed": fixed,
    }
    return out
