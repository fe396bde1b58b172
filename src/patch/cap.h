// What fills the squares at extraordinary vertices that regular pieces leave open.
#pragma once

#include "patch/cap_limit.h"
#include "patch/cap_solver.h"
#include "patch/cap_surface.h"
#include "patch/fan.h"
#include "patch/piece.h"

#include <patchwright/mesh/cage.h>
#include <patchwright/patch/extract.h>

#include <map>
#include <memory>
#include <mutex>
#include <utility>

namespace patchwright::patch {

/// The filling around one irregular fan.
struct Cap {
    Fan fan;
    CapReport report;
    /// Per face of the fan: the corner's square [0, 2^-hole]^2 (seen from the corner) is left by
    /// the regular pieces and filled by `pieces`, which are in the face's own parameters.
    int hole = 0;
    std::vector<std::vector<PolynomialPiece>> pieces;
    /// Whether each face has 2 x 2 pieces that join each other with C1.
    bool is_split = false;
    /// Whether the cap joins what lies outside with C1 only.
    bool is_c1_outside = false;

    /// Parameters seen from the corner where pieces meet, rising, twice where they meet with C1.
    [[nodiscard]] std::vector<double> knots(int steps_to_one_corner) const;
};

/// Fills fans of one cage. Thread-safe.
class CapBuilder {
  public:
    CapBuilder(const mesh::Cage& cage, const ExtractOptions& options, double tolerance_mm,
               subd::RingTable& table);
    ~CapBuilder();

    /// The shallowest cap within the tolerance, at most of the largest depth.
    /// @pre not fan.is_regular()
    [[nodiscard]] Cap build(const Fan& fan);

  private:
    struct Sector;

    /// False when there is no exact solution, or only a folded one. Takes the smoothest solution
    /// within the tolerance, else the nearest.
    /// @param corner  the solver of a fan of kind Corner, made by the first call
    [[nodiscard]] bool fill_smoothly(const std::vector<Sector>& sectors, Cap& cap,
                                     std::unique_ptr<CapSolver>& corner);
    static void set_pieces(const CapSolver::Net& net, const std::vector<Sector>& sectors, Cap& cap);
    static void fill_by_limit(const std::vector<Sector>& sectors, Cap& cap);
    /// Of fits with ever less weight on bending takes the first within the tolerance, else the
    /// nearest one or the cap as it is.
    void fit_smoothly(const std::vector<Sector>& sectors, const CapSolver& solver,
                      const CapSolver::Net& net, Cap& cap);
    /// @param normals  by sector
    static void take_normals(const std::vector<geom::Points>& normals,
                             std::vector<CapSolver::Target>& targets);
    void find_check_points(std::vector<Sector>& sectors);
    /// Whether the cap faces away from most of itself somewhere, and the limit surface does not.
    [[nodiscard]] static bool folds(const Cap& cap, const std::vector<Sector>& sectors);
    [[nodiscard]] static double distance(const Cap& cap, const std::vector<Sector>& sectors);
    /// Its pieces seen from the vertex, in shares of the cap's size.
    static CapSurface surface_of(const Cap& cap, const std::vector<Sector>& sectors);
    /// @param limit  by sector
    [[nodiscard]] static std::vector<CapSurface::CapFoot> feet(
        const Cap& cap, const std::vector<Sector>& sectors, const std::vector<geom::Points>& limit,
        Samples samples);
    const CapSolver& solver_of(FanKind kind, int size);

    const mesh::Cage& cage_;
    ExtractOptions options_;
    double tolerance_mm_;
    subd::RingTable& table_;
    std::mutex mutex_;
    std::map<std::pair<FanKind, int>, std::unique_ptr<CapSolver>> solvers_;
    LimitSampler limit_;
};

}  // namespace patchwright::patch
