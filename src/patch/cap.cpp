#include "patch/cap.h"

#include "patch/cap_solver.h"

#include <patchwright/subd/limit_mask.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

namespace patchwright::patch {

using geom::Points;
using mesh::CornerId;
using mesh::Topology;
using subd::RingKind;

namespace {

/// Parameters in a cap, as shares of its size, where its distance is measured.
constexpr double sample_shares[] = {0.04, 0.2, 0.4, 0.6, 0.8};
constexpr int samples_a_side = 5;
/// Where tangent planes do not agree, knots go at least so deep to keep the kink small.
constexpr int depth_of_kinks = 8;

/// Of a corner's parameters (s along the edge that leaves it, t along the one that arrives) those
/// of the face.
Eigen::Vector2d face_parameters(int corner, double s, double t) {
    switch (corner) {
        case 0: return {s, t};
        case 1: return {1.0 - t, s};
        case 2: return {1.0 - s, 1.0 - t};
        default: return {t, 1.0 - s};
    }
}

/// Knots 0, 0, 0, 1/2, 1/2, 1/2, 1, 1, 1: three from k on are the blossom's arguments of point k.
Eigen::Vector3d half_triple(int k) {
    const auto knot = [](int i) { return 0.5 * double(i / 3); };
    return {knot(k), knot(k + 1), knot(k + 2)};
}

Eigen::Vector3d unit_triple(int k) {
    return {k > 2 ? 1.0 : 0.0, k > 1 ? 1.0 : 0.0, k > 0 ? 1.0 : 0.0};
}

/// The angle between neighbouring edges at a corner whose sharp edges span the tangent plane; empty
/// when they do not, or hardly. The limit surface may be folded ever closer to the vertex
/// (Biermann, Levin, Zorin 2000); where edges lie is told by their far ends.
std::optional<double> corner_angle(const Eigen::Matrix<double, Eigen::Dynamic, 3>& net, int n) {
    const auto from_vertex = [&](int s, int i, int j) -> Eigen::Vector3d {
        return (net.row(cap_row(s, i, j)) - net.row(0)).transpose();
    };
    const Eigen::Vector3d first = from_vertex(0, 1, 0);
    const Eigen::Vector3d last = from_vertex(n - 1, 0, 1);
    std::vector<Eigen::Vector3d> edges{first};
    for (int s = 1; s < n; ++s) edges.push_back(from_vertex(s, 6, 0));
    edges.push_back(last);

    Eigen::Vector3d facing = Eigen::Vector3d::Zero();
    for (int s = 0; s < n; ++s) {
        facing += edges[std::size_t(s)].cross(edges[std::size_t(s + 1)]);
    }
    Eigen::Vector3d normal = first.cross(last);
    if (normal.dot(facing) < 0.0) normal = -normal;
    if (!(normal.norm() > 0.1 * first.norm() * last.norm())) return {};
    normal.normalize();
    double total = 0.0;
    for (int s = 0; s < n; ++s) {
        const Eigen::Vector3d& a = edges[std::size_t(s)];
        const Eigen::Vector3d& b = edges[std::size_t(s + 1)];
        total += std::atan2(normal.dot(a.cross(b)), a.dot(b));
    }
    const double angle = total / n;
    if (!(angle > 0.05) || !(angle < 0.95 * M_PI)) return {};
    return angle;
}

Piece in_face(Piece piece, int corner, double size) {
    piece.u0 *= size;
    piece.v0 *= size;
    piece.size *= size;
    return seen_from(piece, (4 - corner) % 4);
}

}  // namespace

/// One face of a fan after the steps that its cap leaves to regular pieces; parameters are seen
/// from the corner, in units of the square that is left.
struct CapBuilder::Sector {
    const RingKind* kind;
    Points local;
    int corner;

    void descend() {
        const RingKind::Child& child = kind->child(corner);
        local = (child.matrix * local).eval();
        kind = child.kind;
    }
    [[nodiscard]] Eigen::RowVector3d limit() const { return kind->corner(corner).limit * local; }
    /// The regular pieces [1/2, 1] x [0, 1/2], [1/2, 1]^2 and [0, 1/2] x [1/2, 1].
    [[nodiscard]] std::array<Piece, 3> outer_pieces() const {
        std::array<Piece, 3> pieces;
        constexpr double origin[3][2] = {{0.5, 0.0}, {0.5, 0.5}, {0.0, 0.5}};
        for (int k = 0; k < 3; ++k) {
            const RingKind::Child& child = kind->child((corner + k + 1) % 4);
            Piece piece;
            piece.control = child.kind->regular() * (child.matrix * local);
            piece = seen_from(piece, corner);
            piece.u0 = origin[k][0];
            piece.v0 = origin[k][1];
            piece.size = 0.5;
            pieces[std::size_t(k)] = piece;
        }
        return pieces;
    }
};

/// A cap as one surface that points are projected on.
class CapBuilder::CapSurface {
  public:
    CapSurface(const Cap& cap, const std::vector<Sector>& sectors) : closed_(cap.fan.is_closed()) {
        for (std::size_t s = 0; s < sectors.size(); ++s) {
            std::vector<Piece> pieces;
            for (Piece piece : cap.pieces[s]) {
                piece = seen_from(piece, sectors[s].corner);
                piece.u0 = std::ldexp(piece.u0, cap.hole);
                piece.v0 = std::ldexp(piece.v0, cap.hole);
                piece.size = std::ldexp(piece.size, cap.hole);
                pieces.push_back(piece);
            }
            pieces_.push_back(std::move(pieces));
        }
    }

    /// From `p` to its foot near (u, v) of a face, parameters in units of the cap.
    [[nodiscard]] double distance(const Eigen::RowVector3d& p, int s, double u, double v) const {
        const int n = static_cast<int>(pieces_.size());
        double best = std::numeric_limits<double>::infinity();
        for (int step = 0; step < 12; ++step) {
            const Tangent at = tangent(s, u, v);
            const Eigen::RowVector3d off = p - at.position;
            const double distance = off.norm();
            if (distance > 0.999 * best) return std::min(distance, best);
            best = distance;
            // Gauss-Newton: the nearest point of the tangent plane.
            const double uu = at.du.dot(at.du), uv = at.du.dot(at.dv), vv = at.dv.dot(at.dv);
            const double determinant = uu * vv - uv * uv;
            if (!(determinant > 1e-12 * uu * vv)) return best;
            const double a = at.du.dot(off), b = at.dv.dot(off);
            u += (vv * a - uv * b) / determinant;
            v += (uu * b - uv * a) / determinant;
            // Past an edge the neighbour goes on, its own edge turned onto this one's.
            if (v < 0.0 && v <= u && (closed_ || s > 0)) {
                s = (s + n - 1) % n;
                std::tie(u, v) = std::pair(-v, u);
            } else if (u < 0.0 && (closed_ || s + 1 < n)) {
                s = (s + 1) % n;
                std::tie(u, v) = std::pair(v, -u);
            }
            u = std::clamp(u, 0.0, 1.0);
            v = std::clamp(v, 0.0, 1.0);
        }
        return best;
    }

  private:
    struct Tangent {
        Eigen::RowVector3d position, du, dv;
    };

    [[nodiscard]] Tangent tangent(int s, double u, double v) const {
        const auto& pieces = pieces_[std::size_t(s)];
        const Piece* piece = &pieces.front();
        for (const Piece& candidate : pieces) {
            if (candidate.contains(u, v)) piece = &candidate;
        }
        const Eigen::Matrix<double, 4, 2> bu = bernstein((u - piece->u0) / piece->size);
        const Eigen::Matrix<double, 4, 2> bv = bernstein((v - piece->v0) / piece->size);
        Tangent result{Eigen::RowVector3d::Zero(), Eigen::RowVector3d::Zero(),
                       Eigen::RowVector3d::Zero()};
        for (int i = 0; i < 4; ++i) {
            const Eigen::Matrix<double, 2, 3> row =
                bv.transpose() * piece->control.middleRows<4>(4 * i);
            result.position += bu(i, 0) * row.row(0);
            result.du += bu(i, 1) / piece->size * row.row(0);
            result.dv += bu(i, 0) / piece->size * row.row(1);
        }
        return result;
    }

    /// Values and derivatives.
    static Eigen::Matrix<double, 4, 2> bernstein(double t) {
        const double s = 1.0 - t;
        Eigen::Matrix<double, 4, 2> b;
        b << s * s * s, -3.0 * s * s, 3.0 * t * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * t * s,
            3.0 * t * (2.0 * s - t), t * t * t, 3.0 * t * t;
        return b;
    }

    std::vector<std::vector<Piece>> pieces_;
    bool closed_;
};

std::vector<double> Cap::knots(int steps_to_one_corner) const {
    std::vector<double> result;
    const int depth = report.depth;
    for (int level = depth; level > steps_to_one_corner; --level) {
        const bool twice = is_split && (level == depth || (level == hole && is_c1_outside));
        result.insert(result.end(), twice ? 2 : 1, std::ldexp(1.0, -level));
    }
    if (is_c1_outside && hole <= steps_to_one_corner) {
        result.insert(result.end(), 2, std::ldexp(1.0, -hole));
    }
    return result;
}

CapBuilder::CapBuilder(const mesh::Cage& cage, const ExtractOptions& options, double tolerance_mm,
                       subd::RingTable& table)
    : cage_(cage), options_(options), tolerance_mm_(tolerance_mm), table_(table) {}

CapBuilder::~CapBuilder() = default;

const CapSolver& CapBuilder::solver(FanKind kind, int size) {
    const std::lock_guard lock(mutex_);
    auto& solver = solvers_[{kind, size}];
    if (!solver) solver = std::make_unique<CapSolver>(kind, size);
    return *solver;
}

const Eigen::MatrixXd& CapBuilder::sample_masks(const RingKind& kind, int corner) {
    const std::lock_guard lock(mutex_);
    Eigen::MatrixXd& masks = masks_[{&kind, corner}];
    if (masks.size() == 0) {
        masks.resize(samples_a_side * samples_a_side, kind.slots());
        for (int a = 0; a < samples_a_side; ++a) {
            for (int b = 0; b < samples_a_side; ++b) {
                const Eigen::Vector2d uv =
                    face_parameters(corner, sample_shares[a], sample_shares[b]);
                masks.row(samples_a_side * a + b) =
                    subd::ring_mask(kind, uv.x(), uv.y()).position();
            }
        }
    }
    return masks;
}

double CapBuilder::distance(const Cap& cap, const std::vector<Sector>& sectors) {
    const CapSurface surface(cap, sectors);
    double largest = 0.0;
    for (std::size_t s = 0; s < sectors.size(); ++s) {
        const Sector& sector = sectors[s];
        const Points limit = sample_masks(*sector.kind, sector.corner) * sector.local;
        for (int a = 0; a < samples_a_side; ++a) {
            for (int b = 0; b < samples_a_side; ++b) {
                largest = std::max(largest, surface.distance(limit.row(samples_a_side * a + b),
                                                             static_cast<int>(s), sample_shares[a],
                                                             sample_shares[b]));
            }
        }
    }
    return largest;
}

bool CapBuilder::fill_smoothly(const std::vector<Sector>& sectors, Cap& cap,
                               std::unique_ptr<CapSolver>& corner) {
    const FanKind kind = cap.fan.kind;
    const int n = cap.fan.size();
    if (kind == FanKind::Spike || n < 2) return false;
    Net net(Eigen::Index(cap_points) * n, 3);
    for (int s = 0; s < n; ++s) {
        const auto outer = sectors[std::size_t(s)].outer_pieces();
        for (int i = 0; i < cap_side; ++i) {
            for (int j = 0; j < cap_side; ++j) {
                // Towards the vertex the pieces are continued, which gives the sharp edges, whose
                // curves are regular.
                const std::size_t piece = (i <= 3 && j > 3) || (i == 0 && j > 0) ? 2
                                          : j <= 3                               ? 0
                                                                                 : 1;
                net.row(cap_row(s, i, j)) = outer[piece].blossom(half_triple(i), half_triple(j));
            }
        }
        net.row(cap_row(s, 0, 0)) = sectors[0].limit();
    }
    if (kind == FanKind::Corner) {
        if (!corner) {
            const std::optional<double> angle = corner_angle(net, n);
            if (!angle) return false;
            corner = std::make_unique<CapSolver>(kind, n, *angle);
        }
        corner->solve(net);
    } else {
        solver(kind, n).solve(net);
    }
    cap.is_split = true;
    cap.is_c1_outside = kind == FanKind::Ring && n % 2 == 0;
    for (int s = 0; s < n; ++s) {
        for (const int i0 : {0, 3}) {
            for (const int j0 : {0, 3}) {
                Piece piece{i0 / 6.0, j0 / 6.0, 0.5, Piece::Form::Bezier, {}};
                for (int i = 0; i < 4; ++i) {
                    for (int j = 0; j < 4; ++j) {
                        piece.control.row(4 * i + j) = net.row(cap_row(s, i0 + i, j0 + j));
                    }
                }
                cap.pieces[std::size_t(s)].push_back(
                    in_face(piece, sectors[std::size_t(s)].corner, std::ldexp(1.0, -cap.hole)));
            }
        }
    }
    return true;
}

void CapBuilder::fill_by_limit(const std::vector<Sector>& sectors, Cap& cap) {
    cap.hole = cap.report.depth;
    for (std::size_t s = 0; s < sectors.size(); ++s) {
        const auto outer = sectors[s].outer_pieces();
        Piece piece{0.0, 0.0, 1.0, Piece::Form::Bezier, {}};
        for (int i = 0; i < 4; ++i) {
            for (int j = 0; j < 4; ++j) {
                piece.control.row(4 * i + j) =
                    i == 0 && j == 0
                        ? sectors[s].limit()
                        : outer[i == 0 ? 2 : 0].blossom(0.5 * unit_triple(i), 0.5 * unit_triple(j));
            }
        }
        cap.pieces[s].push_back(in_face(piece, sectors[s].corner, std::ldexp(1.0, -cap.hole)));
    }
}

Cap CapBuilder::build(const Fan& fan) {
    const Topology& t = *cage_.topology;
    std::vector<Sector> sectors;
    std::vector<int> steps;
    for (const CornerId c : fan.corners) {
        const subd::Ring ring = table_.ring(t, t.face(c));
        sectors.push_back({ring.kind, gather(ring, cage_.points), position(t, c)});
        steps.push_back(steps_to_one_corner(*ring.kind, position(t, c)));
    }
    const int first_level = *std::max_element(steps.begin(), steps.end());
    for (int level = 0; level < first_level; ++level) {
        for (Sector& sector : sectors) sector.descend();
    }
    const bool alone = fan.size() == 1;
    std::unique_ptr<CapSolver> corner;
    bool smooth = options_.join == Join::G1 && !alone;
    for (int depth = first_level + 1;; ++depth) {
        Cap cap{.fan = fan, .hole = depth - 1};
        cap.report = {.vertex = fan.vertex, .faces = fan.size(), .depth = depth};
        cap.pieces.resize(sectors.size());
        const std::vector<Sector> outside = sectors;
        for (Sector& sector : sectors) sector.descend();
        smooth = smooth && fill_smoothly(outside, cap, corner);
        if (!smooth) fill_by_limit(outside, cap);
        cap.report.smooth = smooth || alone;
        cap.report.distance_mm = distance(cap, smooth ? outside : sectors);
        const bool last = depth >= max_cap_depth;
        if (options_.cap_depth) {
            if (depth >= *options_.cap_depth || last) return cap;
        } else if (last || (cap.report.distance_mm <= tolerance_mm_ &&
                            (cap.report.smooth || depth >= depth_of_kinks))) {
            return cap;
        }
    }
}

}  // namespace patchwright::patch
