#include "make_sample_wing.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <vector>

namespace sample_wing {

namespace {

double mix(double root, double tip, double eta) { return root + (tip - root) * eta; }

/// Control points of the uniform cubic B-spline with natural ends whose joints are the given
/// points, which is also how the limit of a row of cage vertices between two creases looks.
std::vector<gp_XYZ> control_points(const std::vector<gp_XYZ>& joints) {
    std::vector<gp_XYZ> c = joints;
    for (int sweep = 0; sweep < 200; ++sweep) {  // Gauss-Seidel on (c[i-1] + 4 c[i] + c[i+1]) / 6
        for (std::size_t i = 1; i + 1 < c.size(); ++i) {
            c[i] = (joints[i] * 6 - c[i - 1] - c[i + 1]) / 4;
        }
    }
    return c;
}

/// Control points in rows from the root to the tip; a row runs around the section from the lower
/// to the upper trailing edge.
/// @param loop  see skin_point
std::vector<std::vector<gp_XYZ>> control_rows(const std::vector<double>& loop,
                                              const std::vector<double>& span) {
    const int m = static_cast<int>(span.size()) + 2;  // two more rows for the cap
    const int around = static_cast<int>(loop.size());
    // Joints of the rows along the span; the cap's two rows are control points already.
    std::vector<std::vector<gp_XYZ>> rows;
    const auto section = [&](double eta) {
        std::vector<gp_XYZ> joints;
        for (double s : loop) joints.push_back(skin_point(s, eta).XYZ());
        return control_points(joints);
    };
    for (double eta : span) rows.push_back(section(eta));
    const std::vector<gp_XYZ> tip = section(1);
    for (int row = 0; row < 2; ++row) {
        // A cubic B-spline through the half ellipse's start, its end and a point between.
        const double height = row == 0 ? 1.05 : 0.65;
        const double length = row == 0 ? 0 : 1.04 * cap_aspect;
        rows.emplace_back();
        for (int i = 0; i < around; ++i) {
            const gp_XYZ& other = tip[around - 1 - i];
            const gp_XYZ middle = (tip[i] + other) / 2;
            const gp_XYZ half = (tip[i] - other) / 2;
            const gp_XYZ out = span_direction(loop[i] * loop[i]).XYZ() * std::abs(half.Z());
            rows.back().push_back(middle + half * height + out * length);
        }
    }
    for (int i = 0; i < around; ++i) {
        std::vector<gp_XYZ> joints;
        for (int j = 0; j + 1 < m; ++j) joints.push_back(rows[j][i]);
        const std::vector<gp_XYZ> column = control_points(joints);
        for (int j = 0; j + 1 < m; ++j) rows[j][i] = column[j];
    }
    return rows;
}

/// Vertices of the cage, which count from 0.
struct Numbering {
    int stations;  ///< on each side of the section
    int rows;

    [[nodiscard]] int around() const { return 2 * stations; }
    [[nodiscard]] int upper(int i, int j) const { return j * around() + stations + i; }
    [[nodiscard]] int lower(int i, int j) const { return j * around() + stations - 1 - i; }
};

void write_faces(std::ostream& out, const Numbering& number) {
    const int last = number.stations - 1, m = number.rows;
    const auto upper = [&](int i, int j) { return number.upper(i, j); };
    const auto lower = [&](int i, int j) { return number.lower(i, j); };
    const auto quad = [&](int a, int b, int c, int d) {
        out << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << ' ' << d + 1 << '\n';
    };
    const auto strip = [&](const char* name, int count, const std::function<void(int)>& face) {
        out << "g " << name << '\n';
        for (int k = 0; k < count; ++k) face(k);
    };
    const int cells = last * (m - 1);
    strip("upper", cells, [&](int k) {
        const int i = k % last, j = k / last;
        quad(upper(i, j), upper(i + 1, j), upper(i + 1, j + 1), upper(i, j + 1));
    });
    strip("lower", cells, [&](int k) {
        const int i = k % last, j = k / last;
        quad(lower(i + 1, j), lower(i, j), lower(i, j + 1), lower(i + 1, j + 1));
    });
    strip("nose", m - 1,
          [&](int j) { quad(lower(0, j), upper(0, j), upper(0, j + 1), lower(0, j + 1)); });
    strip("te", m - 1, [&](int j) {
        quad(upper(last, j), lower(last, j), lower(last, j + 1), upper(last, j + 1));
    });
    strip("tip", last, [&](int i) {
        quad(upper(i, m - 1), upper(i + 1, m - 1), lower(i + 1, m - 1), lower(i, m - 1));
    });
    strip("root", last,
          [&](int i) { quad(upper(i + 1, 0), upper(i, 0), lower(i, 0), lower(i + 1, 0)); });
}

void write_creases(std::ostream& out, const Numbering& number) {
    const int last = number.stations - 1, m = number.rows, around = number.around();
    const auto upper = [&](int i, int j) { return number.upper(i, j); };
    const auto lower = [&](int i, int j) { return number.lower(i, j); };
    const auto crease = [&](int a, int b) { out << "t crease 2/1/0 " << a << ' ' << b << " 10\n"; };
    for (int j = 0; j + 1 < m; ++j) {
        crease(upper(last, j), upper(last, j + 1));
        crease(lower(last, j), lower(last, j + 1));
    }
    crease(upper(last, m - 1), lower(last, m - 1));
    for (int i = 0; i < around; ++i) crease(i, (i + 1) % around);
}

}  // namespace

gp_Pnt skin_point(double s, double eta, const WingShape& shape) {
    const double chord = mix(1000, 450, eta);
    const double camber = mix(0.02, 0.01, eta);
    const double thickness = shape.thickness * mix(0.12, 0.10, eta);
    const double blunt = shape.thickness * mix(0.004, 0.004, eta);
    const double twist = (mix(2, -1.5, eta) + shape.tip_twist_deg * eta) * M_PI / 180;

    const double x = s * s;
    const double r = std::abs(s);
    const double sharp = -0.1260 * x - 0.3516 * x * x + 0.2843 * x * x * x - 0.1036 * x * x * x * x;
    const double half = 5 * thickness * (0.2969 * r + sharp) + 0.5 * blunt * x;
    const double p = 0.4;
    const bool fore = x < p;
    const double q = fore ? p * p : (1 - p) * (1 - p);
    const double line = camber / q * ((fore ? 0 : 1 - 2 * p) + 2 * p * x - x * x);
    const double slope = std::atan(2 * camber / q * (p - x));
    const double side = s < 0 ? -1 : 1;
    const double cx = x - side * half * std::sin(slope) - 0.25;  // about the quarter chord
    const double cz = line + side * half * std::cos(slope);

    const double y = shape.span_mm * eta;
    return {250 + shape.sweep * y + chord * (cx * std::cos(twist) + cz * std::sin(twist)), y,
            0.06 * y + shape.tip_bend_mm * eta * eta +
                chord * (cz * std::cos(twist) - cx * std::sin(twist))};
}

gp_Vec span_direction(double chord_fraction, const WingShape& shape) {
    const double s = std::sqrt(chord_fraction);
    const auto middle = [&](double eta) {
        return (skin_point(s, eta, shape).XYZ() + skin_point(-s, eta, shape).XYZ()) / 2;
    };
    const gp_Vec d(middle(1) - middle(0.99));
    return d / d.Y();
}

void write_cage(const std::string& path) {
    const std::vector<double> chord{0.08, 0.20, 0.33, 0.47,
                                    0.62, 0.76, 0.90, 1.0};  // s, see skin_point
    const std::vector<double> span{0, 0.22, 0.48, 0.74, 0.93};
    const int n = static_cast<int>(chord.size());
    std::vector<double> loop;
    for (int i = n; i-- > 0;) loop.push_back(-chord[i]);
    loop.insert(loop.end(), chord.begin(), chord.end());
    const std::vector<std::vector<gp_XYZ>> rows = control_rows(loop, span);

    std::ofstream out(path);
    char text[160];
    out << "# Cage for wing.step and wing.igs, millimetres. Written by make_sample_wing.\n";
    for (const auto& row : rows) {
        for (const gp_XYZ& p : row) {
            std::snprintf(text, sizeof text, "v %.2f %.2f %.2f\n", p.X(), p.Y(), p.Z());
            out << text;
        }
    }
    const Numbering number{.stations = n, .rows = static_cast<int>(rows.size())};
    write_faces(out, number);
    write_creases(out, number);
    if (!out.flush()) throw std::runtime_error(path + ": not written");
}

}  // namespace sample_wing
