"""Bad input gets one clear message with place and remedy, a non-zero exit, and nothing is overwritten."""

import subprocess
import unittest

from umov_case import UMOV, UmovCase

PLAN = """sample = "red gloss"
wavelengths_nm = [532]
theta_i_deg = [30]
theta_r_deg = [0, 30]
states = [["P", "P"]]
dwell_ms = 20
"""

HEADER = ("index,time_s,theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,polarizer_deg,analyzer_deg,"
          "direction,gain,x_v,y_v,x_se_v,y_se_v,monitor_v,saturated,shutter")
ROW = "0,0.450,30,0,0,532,0,0,1,100,0.01,0,1e-05,1e-05,1,0,open"


class BadInput(UmovCase):
    def test_a_scan_file_cut_anywhere_is_refused(self):
        self.write("plan.toml", PLAN)
        self.must("scan", "plan.toml", "-o", "scan.h5")
        whole = (self.folder / "scan.h5").read_bytes()
        (self.folder / "keep.h5").write_bytes(b"earlier work")
        for part in (0.1, 0.5, 0.9, 0.999):
            (self.folder / "cut.h5").write_bytes(whole[: int(len(whole) * part)])
            self.refused("reduce", "cut.h5", "-o", "keep.h5", says=["cut.h5"])
            self.assertEqual((self.folder / "keep.h5").read_bytes(), b"earlier work")

    def test_raw_data_and_inputs_are_never_overwritten(self):
        self.write("plan.toml", PLAN)
        self.must("scan", "plan.toml", "-o", "scan.h5")
        self.must("scan", "plan.toml", "-o", "other.h5")
        self.must("export", "other.h5", "--format", "csv", "-o", "other.csv")
        before = {name: (self.folder / name).read_bytes() for name in ("scan.h5", "other.h5", "other.csv")}
        for target in before:
            for command in (["reduce", "scan.h5"], ["calibrate", "scan.h5"], ["report", "scan.h5"],
                            ["invert", "scan.h5", "--model", "nef"], ["emulator", "--certificate", "white-99"]):
                with self.subTest(f"{command[0]} onto {target}"):
                    self.refused(*command, "-o", target, says=[target])
        for name, content in before.items():
            self.assertEqual((self.folder / name).read_bytes(), content)

    def test_a_flipped_bit_in_the_data_is_noticed(self):
        self.write("plan.toml", PLAN)
        self.must("scan", "plan.toml", "-o", "scan.h5")
        whole = bytearray((self.folder / "scan.h5").read_bytes())
        import h5py
        with h5py.File(self.folder / "scan.h5") as file:
            offset = file["records/x_v"].id.get_offset()
        self.assertIsNotNone(offset)
        whole[offset + 6] ^= 1
        (self.folder / "bad.h5").write_bytes(whole)
        self.refused("export", "bad.h5", "--format", "csv", "-o", "out.csv", says=["bad.h5", "checksum"])

    def test_files_without_end_are_refused_at_once(self):
        with open(self.folder / "sparse.h5", "wb") as file:
            file.truncate(30_000_000_000)
        for command in (["import", "-o", "x.h5"], ["export", "--format", "merl", "-o", "x"], ["reduce", "-o", "x.h5"],
                        ["invert", "--model", "nef", "-o", "x.json"]):
            with self.subTest(command[0]):
                self.refused(command[0], "/dev/zero", *command[1:], says=["/dev/zero", "device"])
                self.refused(command[0], "sparse.h5", *command[1:], says=["sparse.h5", "larger than"])

    def test_a_pipe_is_read(self):
        self.write("scan.csv", HEADER + "\n" + ROW + "\n")
        script = f"cat scan.csv | '{UMOV}' import /dev/stdin -o scan.h5"
        done = subprocess.run(["/bin/sh", "-c", script], cwd=self.folder, capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("1 rows", done.stdout)

    def test_csv_faults_name_line_and_column(self):
        cases = {
            "no column": (HEADER.replace("gain,", "") + "\n" + ROW.replace("100,", ""), ["gain"]),
            "NaN": (HEADER + "\n" + ROW.replace("0.01", "nan"), [":2:", "x_v"]),
            "unit": (HEADER.replace("theta_i_deg", "theta_i_rad") + "\n" + ROW, ["theta_i_rad", "deg"]),
            "number": (HEADER + "\n" + ROW.replace("532", "5e3e2"), [":2:", "wavelength_nm"]),
            "fields": (HEADER + "\n" + ROW + ",7", [":2:"]),
            "angle": (HEADER + "\n" + ROW.replace("0.450,30,", "0.450,130,"), [":2:", "theta_i_deg"]),
        }
        for name, (text, says) in cases.items():
            with self.subTest(name):
                self.write("scan.csv", text + "\n")
                self.refused("import", "scan.csv", "-o", "scan.h5", says=["scan.csv", *says])
                self.assertFalse((self.folder / "scan.h5").exists())

    def test_an_unknown_plan_key_is_named_with_the_nearest_known_one(self):
        self.write("plan.toml", PLAN.replace("dwell_ms", "dwel_ms"))
        self.refused("scan", "plan.toml", "-o", "scan.h5", says=["plan.toml:6", "dwel_ms", "dwell_ms"])

    def test_a_plan_beyond_the_limits_is_refused(self):
        self.write("plan.toml", PLAN.replace("[0, 30]", "[0, 130]"))
        self.refused("scan", "plan.toml", "-o", "scan.h5", says=["plan.toml:4", "theta_r_deg"])

    def test_a_plan_beyond_the_limits_of_the_device_is_refused_before_anything_moves(self):
        self.write("plan.toml", PLAN.replace("[532]", "[589]"))
        self.refused("scan", "plan.toml", "-o", "scan.h5", says=["589", "532"])
        self.assertFalse((self.folder / "scan.h5").exists())

    def test_a_device_that_does_not_answer_is_named(self):
        self.write("plan.toml", PLAN)
        self.refused("scan", "plan.toml", "-o", "scan.h5", "--device", "tcp:127.0.0.1:9", says=["127.0.0.1:9", "umov emulator"])
        self.assertFalse((self.folder / "scan.h5").exists())

    def test_an_unknown_sample_lists_those_there_are(self):
        self.write("plan.toml", PLAN)
        self.refused("scan", "plan.toml", "-o", "scan.h5", "--sample", "velvet", says=["velvet", "red-gloss"])

    def test_a_missing_file_is_named(self):
        for command in (["scan", "none.toml", "-o", "a.h5"], ["reduce", "none.h5", "-o", "a.h5"],
                        ["invert", "none.h5", "--model", "li-torrance", "-o", "a.json"],
                        ["calibrate", "none.h5", "-o", "a.h5"], ["report", "none.h5", "-o", "a.html"],
                        ["export", "none.h5", "--format", "csv", "-o", "a.csv"], ["import", "none.csv", "-o", "a.h5"]):
            with self.subTest(command[0]):
                self.refused(*command, says=["none."])

    def test_a_scan_without_calibration_and_without_constants_says_what_to_do(self):
        self.write("plan.toml", PLAN)
        self.must("scan", "plan.toml", "-o", "scan.h5")
        self.refused("reduce", "scan.h5", "-o", "brdf.h5", says=["--calibration"])

    def test_a_sample_scan_is_no_white_standard(self):
        self.write("plan.toml", PLAN)
        self.must("scan", "plan.toml", "-o", "scan.h5")
        self.refused("calibrate", "scan.h5", "-o", "cal.h5", says=["role"])

    def test_wrong_usage_exits_with_2(self):
        self.refused("scam", code=2)
        self.refused("scan", code=2)


if __name__ == "__main__":
    unittest.main()
