"""Luminaires that integration tests simulate."""


def small_chamber(rays):
    """A matt cylinder over one source, seen in few pixels; a distribution of so many rays."""
    return f"""[chamber]
diameter_mm = 43
height_mm = 21.4
wall = {{ model = "lambertian", rho = 0.9 }}
[[source]]
kind = "disk"
diameter_mm = 5
flux_lm = 2
[camera]
view_deg = 30
pixels = [20, 12]
pixel_mm = 2
rays_per_pixel = 50
[goniophotometer]
rays = {rays:g}
planes = 4
"""
