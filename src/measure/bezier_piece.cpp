#include "measure/bezier_piece.h"

#include <Eigen/Geometry>

namespace patchwright::measure {

using geom::Vec3;

namespace {

void bound(BezierPiece& piece, const SurfaceFrame& frame) {
    const auto& net = piece.net;
    const auto framed = (net * frame.map.transpose()).eval();
    Directions along_u, along_v;
    Eigen::Index count_u = 0, count_v = 0;
    for (Eigen::Index k = 0; k < 12; ++k) {
        if ((net.row(k + 4) - net.row(k)).norm() > frame.least_mm)
            along_u.row(count_u++) = framed.row(k + 4) - framed.row(k);
        const Eigen::Index start = k / 3 * 4 + k % 3;
        if ((net.row(start + 1) - net.row(start)).norm() > frame.least_mm)
            along_v.row(count_v++) = framed.row(start + 1) - framed.row(start);
    }
    piece.du = cone_of(along_u, count_u);
    piece.dv = cone_of(along_v, count_v);
    piece.box = {net.colwise().minCoeff().transpose(), net.colwise().maxCoeff().transpose()};
    piece.framed = {framed.colwise().minCoeff().transpose(),
                    framed.colwise().maxCoeff().transpose()};
}

/// Spans that are not empty, by their first knot's number.
std::vector<Eigen::Index> spans_of(const std::vector<double>& knots) {
    std::vector<Eigen::Index> spans;
    for (std::size_t k = 3; k + 4 < knots.size(); ++k)
        if (knots[k] < knots[k + 1]) spans.push_back(Eigen::Index(k));
    return spans;
}

/// The cubic Bernstein polynomials and their derivatives.
struct Bernstein {
    explicit Bernstein(double t) {
        const double r = 1.0 - t;
        value << r * r * r, 3 * t * r * r, 3 * t * t * r, t * t * t;
        derivative << -3 * r * r, 3 * r * (r - 2 * t), 3 * t * (2 * r - t), 3 * t * t;
    }
    Eigen::RowVector4d value, derivative;
};

}  // namespace

geom::BsplineSurface::Evaluation BezierPiece::at(double s, double t) const {
    const Bernstein bs(s), bt(t);
    Eigen::Matrix<double, 4, 3> rows, rows_dt;
    for (Eigen::Index i = 0; i < 4; ++i) {
        rows.row(i) = bt.value * net.middleRows<4>(4 * i);
        rows_dt.row(i) = bt.derivative * net.middleRows<4>(4 * i);
    }
    return {(bs.value * rows).transpose(), (bs.derivative * rows).transpose(),
            (bs.value * rows_dt).transpose()};
}

std::array<BezierPiece, 2> BezierPiece::halves(const SurfaceFrame& frame) const {
    double length_u = 0.0, length_v = 0.0;
    for (Eigen::Index k = 0; k < 12; ++k) length_u += (net.row(k + 4) - net.row(k)).norm();
    for (Eigen::Index k = 0; k < 12; ++k) {
        const Eigen::Index start = k / 3 * 4 + k % 3;
        length_v += (net.row(start + 1) - net.row(start)).norm();
    }
    const bool across_u = length_u >= length_v;
    const Eigen::Index step = across_u ? 4 : 1, next = across_u ? 1 : 4;
    std::array<BezierPiece, 2> parts;
    auto& [low, high] = parts;
    low.u = high.u = u;
    low.v = high.v = v;
    auto& range_low = across_u ? low.u : low.v;
    auto& range_high = across_u ? high.u : high.v;
    range_low[1] = range_high[0] = 0.5 * (range_low[0] + range_low[1]);
    for (Eigen::Index line = 0; line < 4; ++line) {
        const auto point = [&](Eigen::Index k) { return line * next + k * step; };
        const Eigen::RowVector3d a = net.row(point(0)), b = net.row(point(1)),
                                 c = net.row(point(2)), d = net.row(point(3));
        const Eigen::RowVector3d ab = 0.5 * (a + b), bc = 0.5 * (b + c), cd = 0.5 * (c + d);
        const Eigen::RowVector3d abc = 0.5 * (ab + bc), bcd = 0.5 * (bc + cd);
        const Eigen::RowVector3d middle = 0.5 * (abc + bcd);
        low.net.row(point(0)) = a;
        low.net.row(point(1)) = ab;
        low.net.row(point(2)) = abc;
        low.net.row(point(3)) = middle;
        high.net.row(point(0)) = middle;
        high.net.row(point(1)) = bcd;
        high.net.row(point(2)) = cd;
        high.net.row(point(3)) = d;
    }
    for (BezierPiece& part : parts) bound(part, frame);
    return parts;
}

bool run_one_way(const BezierPiece& a, const BezierPiece& b, double least_mm) {
    constexpr double margin = 1e-4;  // radians that decide nothing
    const auto steps = [](const BezierPiece& piece, bool along_u) {
        Directions result;
        for (Eigen::Index k = 0; k < 12; ++k) {
            const Eigen::Index from = along_u ? k : k / 3 * 4 + k % 3;
            result.row(k) = piece.net.row(from + (along_u ? 4 : 1)) - piece.net.row(from);
        }
        return result;
    };
    const std::array<Directions, 2> along_u{steps(a, true), steps(b, true)};
    const std::array<Directions, 2> along_v{steps(a, false), steps(b, false)};
    const Vec3 u = (along_u[0] + along_u[1]).colwise().sum().normalized();
    const Vec3 v = (along_v[0] + along_v[1]).colwise().sum().normalized();
    const Vec3 normal = u.cross(v);
    // In the plane of u and v, at right angles to one of them: each is positive on the other.
    const Vec3 of_u = v.cross(normal), of_v = normal.cross(u);
    const auto all_beyond = [&](const Directions& ways, const Vec3& along) {
        for (Eigen::Index k = 0; k < ways.rows(); ++k) {
            const double length = ways.row(k).norm();
            if (length > least_mm && !(ways.row(k).dot(along) > margin * length)) return false;
        }
        return true;
    };
    for (const double side : {1.0, -1.0}) {
        const Vec3 way = (of_u + side * of_v).normalized();
        for (const std::size_t k : {0u, 1u})
            if (!all_beyond(along_u[k], way) || !all_beyond(along_v[k], side * way)) return false;
    }
    return true;
}

BezierGrid bezier_grid(const geom::BsplineSurface& surface, const SurfaceFrame& frame) {
    const auto us = spans_of(surface.knots_u), vs = spans_of(surface.knots_v);
    BezierGrid grid{us.size(), vs.size(), std::vector<BezierPiece>(us.size() * vs.size())};
    std::vector<Eigen::Matrix4d> of_v;
    for (const Eigen::Index span : vs) of_v.push_back(geom::bezier_matrix(surface.knots_v, span));
    for (std::size_t i = 0; i < us.size(); ++i) {
        const Eigen::Matrix4d of_u = geom::bezier_matrix(surface.knots_u, us[i]);
        for (std::size_t j = 0; j < vs.size(); ++j) {
            BezierPiece& piece = grid.pieces[i * vs.size() + j];
            const auto first_u = std::size_t(us[i]), first_v = std::size_t(vs[j]);
            piece.u = {surface.knots_u[first_u], surface.knots_u[first_u + 1]};
            piece.v = {surface.knots_v[first_v], surface.knots_v[first_v + 1]};
            Eigen::Matrix<double, 16, 3, Eigen::RowMajor> half;
            for (Eigen::Index k = 0; k < 4; ++k) {
                half.middleRows<4>(4 * k) =
                    of_v[j] *
                    surface.points.middleRows<4>((us[i] - 3 + k) * surface.columns() + vs[j] - 3);
            }
            for (Eigen::Index k = 0; k < 4; ++k) {
                piece.net.middleRows<4>(4 * k).setZero();
                for (Eigen::Index l = 0; l < 4; ++l)
                    piece.net.middleRows<4>(4 * k) += of_u(k, l) * half.middleRows<4>(4 * l);
            }
            bound(piece, frame);
        }
    }
    return grid;
}

}  // namespace patchwright::measure
