"""The estimator against a run of the command, turn by turn and to the bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, same_bits

import meniscus_liquid as ml

SHIPPED = ROOT / "recordings" / "glycerine-unseen.safetensors"


@pytest.fixture(scope="module")
def run(program, tmp_path_factory: pytest.TempPathFactory) -> ml.Estimates:
    folder = tmp_path_factory.mktemp("run")
    path = folder / "estimates.safetensors"
    program.run(
        "run", "--patient", "--seconds", "3", "--source", SHIPPED, "--seed", "5", "--estimates", path, "--out", folder
    )
    return ml.Estimates.load(path)


def test_a_tracked_recording_is_the_command_s_run_to_the_bit(run: ml.Estimates, shipped: ml.Recording) -> None:
    assert len(run) == 180
    profiles = shipped.observe(seed=5)[:180]
    mine = ml.Estimator().track(profiles)
    assert mine.mode == run.mode and mine.known == run.known and mine.model_version == run.model_version
    for name in (
        "camera_us", "sequence", "latent", "surface_m", "surface_half_m", "group_half", "acceleration_m_s2", "energy_j", "audit",
    ):
        assert same_bits(getattr(mine, name), getattr(run, name)), name
    covariance = mine.covariance()
    assert same_bits(covariance, run.covariance())
    assert same_bits(covariance, covariance.transpose(0, 2, 1).copy())
    assert (np.linalg.eigvalsh(covariance[100].astype(float)) > -1e-9).all()


def test_turns_give_the_same_and_the_whole_field(run: ml.Estimates, shipped: ml.Recording) -> None:
    estimator = ml.Estimator()
    for turn, profile in enumerate(shipped.observe(seed=5)[:120]):
        estimate = estimator.turn(profile)
        assert same_bits(estimate.latent, run.latent[turn])
        assert same_bits(estimate.covariance, run.covariance()[turn])
    assert estimate.mode == "tracking" and estimate.fields == ["q", "v", "e", "sigma", "tau"]
    assert estimate.field("q").shape == (2134, 3) and estimate.field("e").shape == (2134, 1)
    # The truth comes from the simulator: positions within a few per cent of their displacement (README).
    truth, rest = shipped.field("q")[119].astype(float), shipped.field("q")[0].astype(float)
    error = np.linalg.norm(estimate.field("q") - truth) / np.linalg.norm(truth - rest)
    assert error < 0.2, error
    health = estimator.health
    assert health["turns"] == 120 and health["tracking"] + health["filling"] == 120
    estimator.reset()
    assert estimator.health["turns"] == 0


def test_fewer_fields_are_the_same_numbers_and_others_are_refused(shipped: ml.Recording) -> None:
    all_fields, some = ml.Estimator(), ml.Estimator(fields=["tau", "v"])
    for profile in shipped.profiles()[:40]:
        whole, part = all_fields.turn(profile), some.turn(profile)
    assert part.fields == ["v", "tau"]
    for name in part.fields:
        assert same_bits(part.field(name), whole.field(name))
    with pytest.raises(ml.MeniscusError, match="does not decode the field 'q': it decodes v, tau"):
        part.field("q")
    with pytest.raises(ml.MeniscusError, match="no field is called 'x'"):
        ml.Estimator(fields=["x"])  # type: ignore[list-item]


def test_missing_frames_coast_and_then_halt(shipped: ml.Recording) -> None:
    estimator = ml.Estimator()
    for profile in shipped.profiles()[:60]:
        estimator.turn(profile)
    modes = [estimator.turn(None, motion=(0.0, 0.0)).mode for _ in range(61)]
    assert modes[:60] == ["coasting"] * 60 and modes[60] == "halted"
    assert estimator.health["coasting"] == 60 and estimator.health["halted"] == 1
    halted = estimator.turn(None)
    with pytest.raises(ml.MeniscusError, match="this turn has no field: its mode is halted"):
        halted.field("q")


def test_measured_motion_beats_none(shipped: ml.Recording) -> None:
    profiles = shipped.observe(seed=3)[:300]
    truth = shipped.profile_m[60:300]

    def error(motion) -> float:
        estimates = ml.Estimator().track(profiles, motion=motion)
        return float(np.abs(estimates.surface_m[60:] - truth).mean())

    measured, unobserved = error(shipped.acceleration_m_s2[:300].copy()), error("unobserved")
    assert measured < unobserved, (measured, unobserved)


def test_a_planned_forecast_meets_the_later_truth_better_than_the_present_surface(shipped: ml.Recording) -> None:
    estimator, profiles = ml.Estimator(), shipped.observe(seed=2)
    ahead, missed, still = 15, [], []
    for turn in range(300):
        estimate = estimator.turn(profiles[turn])
        if turn >= 100 and turn % 10 == 0:
            # The port of the turn after frame n is the acceleration of frame n.
            plan = shipped.acceleration_m_s2[turn : turn + ahead].copy()
            forecast = estimator.forecast(ahead, plan)
            truth = shipped.profile_m[turn + ahead]
            missed.append(np.abs(forecast.surface_m - truth).mean())
            still.append(np.abs(estimate.surface_m - truth).mean())
            assert (forecast.half_width_m > 0).all()
            assert (estimator.forecast(ahead).half_width_m > forecast.half_width_m).any()
    assert np.mean(missed) < 0.2 * np.mean(still), (np.mean(missed), np.mean(still))
    crest = estimator.next_crest(60, np.zeros(60))
    assert crest is None or (0 <= crest["frames"] < 60 and crest["height_m"] > 0.06)


def test_estimates_come_back_from_their_file(run: ml.Estimates, tmp_path: Path) -> None:
    path = tmp_path / "estimates.safetensors"
    run.save(path)
    assert same_bits(ml.Estimates.load(path).latent, run.latent)
    with pytest.raises(ml.MeniscusError, match="expected 'meniscus estimates 2'"):
        ml.Estimates.load(SHIPPED)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: ml.Profile(np.zeros(20), 1e-4), "height_m has 20 numbers: a profile has 21 points"),
        (lambda: ml.Profile(np.full(21, 0.07), -1e-4), "a deviation is not negative"),
        (lambda: ml.Profile(np.full(21, np.inf), 1e-4), "point 0 has the height inf m"),
        (lambda: ml.Profile(np.full(21, 0.07), 1e-4, glass_x_m=np.nan), "glass_x_m = NaN"),
        (lambda: ml.Estimator().turn(None, motion="guessed"), "motion = 'guessed': take \"tracked\""),
        (lambda: ml.Estimator().turn(None, motion=(np.nan, 0.0)), "accelerations must be finite"),
        (lambda: ml.Estimator().track([None], motion=np.zeros(2)), "2 accelerations for 1 profiles"),
        (lambda: ml.Estimator().forecast(601), "frames = 601 is out of range: 0 to 600"),
        (lambda: ml.Estimator().forecast(2, np.array([0.0, np.nan])), r"plan\[1\] = NaN"),
    ],
)
def test_bad_input_is_refused(call, message: str) -> None:
    with pytest.raises(ml.MeniscusError, match=message):
        call()


def test_profiles_pass_through_a_csv_file(shipped: ml.Recording, tmp_path: Path) -> None:
    seen = [profile for profile in shipped.observe(seed=4)[:30] if profile is not None]
    path = tmp_path / "profiles.csv"
    ml.save_profiles(path, seen)
    loaded = ml.load_profiles(path)
    assert len(loaded) == len(seen)
    for one, other in zip(loaded, seen):
        assert same_bits(one.height_m, other.height_m) and one.glass_x_m == other.glass_x_m
    path.write_text(path.read_text().replace("\n", "\nx", 2))
    with pytest.raises(ml.MeniscusError, match="profiles.csv: line "):
        ml.load_profiles(path)


def test_a_camera_s_recording_gives_the_command_s_profiles(program, tmp_path: Path) -> None:
    """The program records its simulated camera and writes the profiles as CSV; Python reads the MCAP file itself."""
    mcap, setup, csv = tmp_path / "camera.mcap", tmp_path / "glass.toml", tmp_path / "profiles.csv"
    program.run("record", "--source", "simulated-usb", "--seconds", "1.5", "--out", mcap)
    measures = ["--radius-mm", "35", "--fill-mm", "70", "--rim-mm", "110"]
    program.run("setup", "--source", "simulated-usb", *measures, "--yes", "--out", setup)
    program.run("record", "--source", mcap, "--setup", setup, "--out", csv)
    profiles = ml.camera_profiles(mcap, setup)
    seen = [profile for profile in profiles if profile is not None]
    assert len(profiles) >= 60 and len(seen) > 0.9 * len(profiles)
    expected = ml.load_profiles(csv)
    assert len(seen) == len(expected)
    for one, other in zip(seen, expected):
        assert same_bits(one.height_m, other.height_m) and one.captured_us == other.captured_us
    # A model of this glass sees the same; a setup of another glass is refused.
    fitted = ml.camera_profiles(mcap, setup, model=ml.Model())
    assert sum(profile is not None for profile in fitted) == len(seen)
    setup.write_text(setup.read_text().replace("fill_mm = 70.0", "fill_mm = 60.0"))
    with pytest.raises(ml.MeniscusError, match="glass.toml: the model was made for a glass with fill 70.0 mm"):
        ml.camera_profiles(mcap, setup, model=ml.Model())
    with pytest.raises(ml.MeniscusError, match="camera.mcap is no settings file|camera.mcap"):
        ml.camera_profiles(mcap, mcap)


def test_the_model_states_facts_and_gives_its_tensors(tmp_path: Path) -> None:
    model = ml.Model()
    assert (model.liquid, model.fill_m, model.validity) == ("glycerine", 0.07, None)
    assert model.known == ["q", "v", "e", "sigma", "tau", "surface"]
    assert bytes(model) == (ROOT / "models" / "glycerine.blob").read_bytes()
    tensors = model.tensors()
    assert len(tensors) > 20 and all(np.isfinite(tensor).all() for tensor in tensors.values())
    path = tmp_path / "model.blob"
    model.save(path)
    assert bytes(ml.Model(path)) == bytes(model)
    damaged = bytearray(bytes(model))
    damaged[-1] ^= 1
    with pytest.raises(ml.MeniscusError, match="the blob is damaged: its CRC-32"):
        ml.Model.from_bytes(bytes(damaged))
    path.write_bytes(bytes(model)[:1000])
    with pytest.raises(ml.MeniscusError, match="model.blob: the blob is cut short: 1000 bytes"):
        ml.Model(path)
    with pytest.raises(OSError, match="nothing.blob"):
        ml.Model(tmp_path / "nothing.blob")
