#include "fit/bench_peers.h"
#include "support/bench.h"

#include <fmt/format.h>

#include <fstream>

#ifdef PATCHWRIGHT_HAS_CHOLMOD
#include <cholmod.h>
#include <dlfcn.h>

#include <climits>
#include <cstdlib>

extern "C" void dgemm_();
#endif

namespace patchwright::bench {

using geom::Points;

#ifndef PATCHWRIGHT_HAS_CHOLMOD

CholeskyResult solve_cholmod(const SparseRows&, const Points&) {
    return {.missing = "built without libsuitesparse-dev"};
}

#else

namespace {

/// The file that the linked dgemm comes from, and OpenBLAS' own description.
std::string blas_name() {
    Dl_info info{};
    std::string name = "unknown";
    char path[PATH_MAX];
    if (dladdr(reinterpret_cast<void*>(&dgemm_), &info) != 0 && info.dli_fname != nullptr) {
        name = realpath(info.dli_fname, path) != nullptr ? path : info.dli_fname;
    }
    if (void* config = dlsym(RTLD_DEFAULT, "openblas_get_config")) {
        name += fmt::format(" ({})", reinterpret_cast<char* (*)()>(config)());
    }
    return name;
}

double free_memory_gb() {
    std::ifstream file("/proc/meminfo");
    for (std::string key, unit; file >> key;) {
        double kilobytes = 0.0;
        file >> kilobytes;
        std::getline(file, unit);
        if (key == "MemAvailable:") return kilobytes / 1e6;
    }
    return 0.0;
}

}  // namespace

CholeskyResult solve_cholmod(const SparseRows& matrix, const Points& b) {
    CholeskyResult result;
    result.blas = blas_name();
    cholmod_common common;
    cholmod_l_start(&common);
    common.supernodal = CHOLMOD_SUPERNODAL;
    Eigen::SparseMatrix<double, Eigen::ColMajor, SuiteSparse_long> normal;
    Points right(matrix.cols(), 3);
    result.form = test::seconds([&] {
        const Eigen::SparseMatrix<double> columns = matrix;
        const Eigen::SparseMatrix<double> product = columns.transpose() * columns;
        normal = product.triangularView<Eigen::Lower>();
        for (int c = 0; c < 3; ++c) right.col(c) = columns.transpose() * Eigen::VectorXd(b.col(c));
    });
    cholmod_sparse a{};
    a.nrow = a.ncol = std::size_t(normal.rows());
    a.nzmax = std::size_t(normal.nonZeros());
    a.p = normal.outerIndexPtr();
    a.i = normal.innerIndexPtr();
    a.x = normal.valuePtr();
    a.stype = -1;
    a.itype = CHOLMOD_LONG;
    a.xtype = CHOLMOD_REAL;
    a.dtype = CHOLMOD_DOUBLE;
    a.packed = a.sorted = 1;
    cholmod_factor* factor = nullptr;
    result.analyze = test::seconds([&] { factor = cholmod_l_analyze(&a, &common); });
    result.factor_gb = common.lnz * 8e-9;
    const double room = free_memory_gb();
    if (factor == nullptr || 1.3 * result.factor_gb > room) {
        result.missing =
            fmt::format("the factor takes {:.1f} GB, {:.1f} GB are free", result.factor_gb, room);
    } else {
        result.factorize = test::seconds([&] { cholmod_l_factorize(&a, factor, &common); });
        if (common.status != CHOLMOD_OK) result.missing = "not factorized";
    }
    if (result.missing.empty()) {
        Eigen::MatrixXd dense = right;  // by columns
        cholmod_dense rhs{};
        rhs.nrow = rhs.d = std::size_t(dense.rows());
        rhs.ncol = 3;
        rhs.nzmax = std::size_t(dense.size());
        rhs.x = dense.data();
        rhs.xtype = CHOLMOD_REAL;
        rhs.dtype = CHOLMOD_DOUBLE;
        result.solve = test::seconds([&] {
            cholmod_dense* x = cholmod_l_solve(CHOLMOD_A, factor, &rhs, &common);
            result.x = Eigen::Map<Eigen::MatrixXd>(static_cast<double*>(x->x), dense.rows(), 3);
            cholmod_l_free_dense(&x, &common);
        });
    }
    cholmod_l_free_factor(&factor, &common);
    cholmod_l_finish(&common);
    return result;
}

#endif

}  // namespace patchwright::bench
