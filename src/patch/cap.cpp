#include "patch/cap.h"

#include "patch/cap_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

namespace patchwright::patch {

using geom::Points;
using mesh::CornerId;
using mesh::Topology;
using subd::RingKind;

namespace {

/// What third derivatives count beside distances from the limit surface, in the order of trial:
/// alone, then less and less. Yet less makes waves at valence 12.
constexpr double weights_of_bending[] = {0.03, 0.01, 0.003};
constexpr int fit_rounds = 2;

/// Corners whose sharp edges are nearer to parallel than this (sine), and sectors narrower or wider
/// than these (radians), are not made smooth: their caps would fold.
constexpr double least_corner_sine = 0.1;
constexpr double least_sector_rad = 0.05, widest_sector_rad = 0.95 * M_PI;

/// Where tangent planes do not agree, or parameters turn over at a corner, knots go so deep if
/// nothing less helps: kinks and folds are small there.
constexpr int depth_of_kinks = 8;

/// Where fits are looked at for parameters that turn over: closer to the vertex, where a sharp tip
/// is rounded, and on the edges; corners, whose few faces may span nearly a whole turn, more
/// closely, beside the knots as well.
constexpr std::array shares_of_fits{0.0, 0.01, 0.03, 0.08, 0.16, 0.27, 0.4, 0.6, 0.8};
constexpr std::array shares_of_corners{0.0,  0.01, 0.03, 0.06, 0.11, 0.17, 0.23,
                                       0.29, 0.35, 0.41, 0.47, 0.5,  0.53, 0.59,
                                       0.65, 0.71, 0.77, 0.83, 0.89, 0.95, 0.99};

/// Knots 0, 0, 0, 1/2, 1/2, 1/2, 1, 1, 1: three from k on are the blossom's arguments of point k.
Eigen::Vector3d half_triple(int k) {
    const auto knot = [](int i) { return 0.5 * double(i / 3); };
    return {knot(k), knot(k + 1), knot(k + 2)};
}

Eigen::Vector3d unit_triple(int k) {
    return {k > 2 ? 1.0 : 0.0, k > 1 ? 1.0 : 0.0, k > 0 ? 1.0 : 0.0};
}

/// The angle between neighbouring edges at a corner whose sharp edges span the tangent plane; empty
/// when they are within 6 degrees of parallel. The limit surface may be folded ever closer to the
/// vertex (Biermann, Levin, Zorin 2000); where edges lie is told by their far ends.
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
    if (!(normal.norm() > least_corner_sine * first.norm() * last.norm())) return {};
    normal.normalize();
    double total = 0.0;
    for (int s = 0; s < n; ++s) {
        const Eigen::Vector3d& a = edges[std::size_t(s)];
        const Eigen::Vector3d& b = edges[std::size_t(s + 1)];
        total += std::atan2(normal.dot(a.cross(b)), a.dot(b));
    }
    const double angle = total / n;
    if (!(angle > least_sector_rad) || !(angle < widest_sector_rad)) return {};
    return angle;
}

PolynomialPiece in_face(PolynomialPiece piece, int corner, double size) {
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
    Points check;  ///< of the limit surface, at the shares where caps are measured

    void descend() {
        const RingKind::Child& child = kind->child(corner);
        local = child.matrix.apply(local);
        kind = child.kind;
    }
    [[nodiscard]] Eigen::RowVector3d limit() const { return kind->corner(corner).limit * local; }
    /// The regular pieces [1/2, 1] x [0, 1/2], [1/2, 1]^2 and [0, 1/2] x [1/2, 1].
    [[nodiscard]] std::array<PolynomialPiece, 3> outer_pieces() const {
        std::array<PolynomialPiece, 3> pieces;
        constexpr double origin[3][2] = {{0.5, 0.0}, {0.5, 0.5}, {0.0, 0.5}};
        for (int k = 0; k < 3; ++k) {
            const RingKind::Child& child = kind->child((corner + k + 1) % 4);
            PolynomialPiece piece;
            piece.control = child.kind->regular() * child.matrix.apply(local);
            piece = seen_from(piece, corner);
            piece.u0 = origin[k][0];
            piece.v0 = origin[k][1];
            piece.size = 0.5;
            pieces[std::size_t(k)] = piece;
        }
        return pieces;
    }
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

const CapSolver& CapBuilder::solver_of(FanKind kind, int size) {
    const std::lock_guard lock(mutex_);
    auto& solver = solvers_[{kind, size}];
    if (!solver) solver = std::make_unique<CapSolver>(kind, size);
    return *solver;
}

void CapBuilder::find_check_points(std::vector<Sector>& sectors) {
    for (Sector& s : sectors) s.check = limit_.points(*s.kind, s.corner, s.local, Samples::Check);
}

CapSurface CapBuilder::surface_of(const Cap& cap, const std::vector<Sector>& sectors) {
    std::vector<std::vector<PolynomialPiece>> pieces = cap.pieces;
    for (std::size_t s = 0; s < sectors.size(); ++s) {
        for (PolynomialPiece& piece : pieces[s]) {
            piece = seen_from(piece, sectors[s].corner);
            piece.u0 = std::ldexp(piece.u0, cap.hole);
            piece.v0 = std::ldexp(piece.v0, cap.hole);
            piece.size = std::ldexp(piece.size, cap.hole);
        }
    }
    return {std::move(pieces), cap.fan.is_closed()};
}

std::vector<CapSurface::CapFoot> CapBuilder::feet(const Cap& cap,
                                                  const std::vector<Sector>& sectors,
                                                  const std::vector<Points>& limit,
                                                  Samples samples) {
    const CapSurface surface = surface_of(cap, sectors);
    const std::span<const double> shares = shares_of(samples);
    std::vector<CapSurface::CapFoot> feet;
    for (std::size_t s = 0; s < limit.size(); ++s) {
        Eigen::Index row = 0;
        for (const double u : shares) {
            for (const double v : shares) {
                feet.push_back(surface.foot(limit[s].row(row++), static_cast<int>(s), u, v));
            }
        }
    }
    return feet;
}

bool CapBuilder::folds(const Cap& cap, const std::vector<Sector>& sectors) {
    const CapSurface surface = surface_of(cap, sectors);
    const std::span<const double> shares = shares_of(Samples::Check);
    std::vector<Points> grids;
    for (std::size_t s = 0; s < sectors.size(); ++s) {
        Points& grid = grids.emplace_back(Eigen::Index(shares.size() * shares.size()), 3);
        Eigen::Index row = 0;
        for (const double u : shares) {
            for (const double v : shares) grid.row(row++) = surface.position(int(s), u, v);
        }
    }
    if (!is_folded(grids)) return false;
    for (std::size_t s = 0; s < sectors.size(); ++s) {
        grids[s] = sectors[s].check;
    }
    return !is_folded(grids);
}

double CapBuilder::distance(const Cap& cap, const std::vector<Sector>& sectors) {
    std::vector<Points> limit;
    for (const Sector& sector : sectors) limit.push_back(sector.check);
    double largest = 0.0;
    for (const CapSurface::CapFoot& foot : feet(cap, sectors, limit, Samples::Check)) {
        largest = std::max(largest, foot.distance);
    }
    return largest;
}

bool CapBuilder::fill_smoothly(const std::vector<Sector>& sectors, Cap& cap,
                               std::unique_ptr<CapSolver>& corner) {
    const FanKind kind = cap.fan.kind;
    const int n = cap.fan.size();
    if (!has_tangent_plane(kind) || n < 2) return false;
    CapSolver::Net net(Eigen::Index(cap_points) * n, 3);
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
    if (kind == FanKind::Corner && !corner) {
        const std::optional<double> angle = corner_angle(net, n);
        if (!angle) return false;
        corner = std::make_unique<CapSolver>(kind, n, *angle);
    }
    const CapSolver* solver = corner ? corner.get() : &solver_of(kind, n);
    cap.is_split = true;
    cap.is_c1_outside = kind == FanKind::Ring && n % 2 == 0;
    const auto take = [&](const CapSolver::Net& solved) {
        set_pieces(solved, sectors, cap);
        cap.report.distance_mm = distance(cap, sectors);
        return cap.report.distance_mm <= tolerance_mm_;
    };
    bool near = take(solver->solve(net));
    if (corner && folds(cap, sectors)) {
        // Whether a corner is convex is hard to tell where the surface between its sharp edges
        // stands upright on their plane. Beside other fans it must not change sides.
        if (fans_around(*cage_.topology, cap.fan.vertex).size() > 1) return false;
        corner = std::make_unique<CapSolver>(kind, n, 2.0 * M_PI / n - corner->angle());
        solver = corner.get();
        near = take(solver->solve(net));
        if (folds(cap, sectors)) return false;
    }
    if (!near) fit_smoothly(sectors, *solver, net, cap);
    return true;
}

void CapBuilder::fit_smoothly(const std::vector<Sector>& sectors, const CapSolver& solver,
                              const CapSolver::Net& net, Cap& cap) {
    std::vector<Points> points, normals;
    for (const Sector& s : sectors)
        points.push_back(limit_.points(*s.kind, s.corner, s.local, Samples::Fit));
    const Cap smoothest = cap;
    Cap best = cap;
    // In faces that are narrow beside the distances, the cap's tangent planes tilt to the side,
    // which turns its parameters over; those of the limit surface do not.
    for (const bool by_limit_normals : {false, true}) {
        if (by_limit_normals)
            for (const Sector& s : sectors)
                normals.push_back(limit_.normals(*s.kind, s.corner, s.local, Samples::Fit));
        bool turned_over = false;
        cap = smoothest;
        for (const double weight : weights_of_bending) {
            for (int round = 0; round < fit_rounds; ++round) {
                std::vector<CapSolver::Target> targets;
                for (const CapSurface::CapFoot& foot : feet(cap, sectors, points, Samples::Fit))
                    targets.push_back(foot.place);
                if (by_limit_normals) take_normals(normals, targets);
                set_pieces(solver.fit(net, targets, weight), sectors, cap);
                if (folds(cap, sectors) || surface_of(cap, sectors).turns_over(shares_of_fits)) {
                    turned_over = true;
                    cap = smoothest;  // going on from its feet makes that worse
                    break;
                }
                cap.report.distance_mm = distance(cap, sectors);
                if (cap.report.distance_mm <= tolerance_mm_) return;
                if (cap.report.distance_mm < best.report.distance_mm) best = cap;
            }
        }
        if (!turned_over) break;
    }
    cap = std::move(best);
}

void CapBuilder::take_normals(const std::vector<Points>& normals,
                              std::vector<CapSolver::Target>& targets) {
    std::size_t k = 0;
    for (const Points& of_sector : normals)
        for (Eigen::Index row = 0; row < of_sector.rows(); ++row, ++k)
            if (!of_sector.row(row).isZero()) targets[k].normal = of_sector.row(row);
}

void CapBuilder::set_pieces(const CapSolver::Net& net, const std::vector<Sector>& sectors,
                            Cap& cap) {
    for (std::size_t s = 0; s < sectors.size(); ++s) {
        cap.pieces[s].clear();
        for (const int i0 : {0, 3}) {
            for (const int j0 : {0, 3}) {
                PolynomialPiece piece{i0 / 6.0, j0 / 6.0, 0.5, PolynomialPiece::Basis::Bezier, {}};
                for (int i = 0; i < 4; ++i) {
                    for (int j = 0; j < 4; ++j) {
                        piece.control.row(4 * i + j) =
                            net.row(cap_row(static_cast<int>(s), i0 + i, j0 + j));
                    }
                }
                cap.pieces[s].push_back(
                    in_face(piece, sectors[s].corner, std::ldexp(1.0, -cap.hole)));
            }
        }
    }
}

void CapBuilder::fill_by_limit(const std::vector<Sector>& sectors, Cap& cap) {
    cap.hole = cap.report.depth;
    cap.is_split = cap.is_c1_outside = false;
    for (std::size_t s = 0; s < sectors.size(); ++s) {
        cap.pieces[s].clear();
        const auto outer = sectors[s].outer_pieces();
        PolynomialPiece piece{0.0, 0.0, 1.0, PolynomialPiece::Basis::Bezier, {}};
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
        sectors.push_back({ring.kind, gather(ring, cage_.points), position(t, c), {}});
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
        cap.report = {.vertex = fan.vertex,
                      .faces = fan.size(),
                      .depth = depth,
                      .limit_has_plane = has_tangent_plane(fan.kind)};
        cap.pieces.resize(sectors.size());
        std::vector<Sector> outside = sectors;
        find_check_points(outside);
        for (Sector& sector : sectors) sector.descend();
        smooth = smooth && fill_smoothly(outside, cap, corner);
        if (!smooth) fill_by_limit(outside, cap);
        cap.report.smooth = smooth || alone;
        if (!smooth) {
            find_check_points(sectors);
            cap.report.distance_mm = distance(cap, sectors);
        }
        const bool last = depth >= max_cap_depth;
        const auto is_even = [&] {
            if (fan.kind != FanKind::Corner || !smooth) return cap.report.smooth;
            return !surface_of(cap, outside).turns_over(shares_of_corners);
        };
        if (options_.cap_depth) {
            if (depth >= *options_.cap_depth || last) return cap;
        } else if (last || (cap.report.distance_mm <= tolerance_mm_ &&
                            (depth >= depth_of_kinks || is_even()))) {
            return cap;
        }
    }
}

}  // namespace patchwright::patch
