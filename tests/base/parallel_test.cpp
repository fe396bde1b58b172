#include <patchwright/base/parallel.h>

#include <catch2/catch.hpp>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

using namespace patchwright;

TEST_CASE("every task runs once, no more at a time than there are threads", "[base]") {
    std::vector<int> runs(50);
    std::atomic<int> running{0}, most{0};
    base::run_tasks(runs.size(), [&](std::size_t i) {
        const int now = ++running;
        for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) {
        }
        ++runs[i];
        --running;
    });
    CHECK(runs == std::vector<int>(50, 1));
    CHECK(most <= base::thread_count());
    base::run_tasks(0, [](std::size_t) { FAIL("there are no tasks"); });
}

TEST_CASE("parallel loops within a task stay on its thread", "[base]") {
    std::atomic<bool> elsewhere{false};
    base::run_tasks(4, [&](std::size_t) {
        const auto own = std::this_thread::get_id();
        base::parallel_for(1000, 1, [&](std::size_t, std::size_t) {
            if (std::this_thread::get_id() != own) elsewhere = true;
        });
    });
    CHECK_FALSE(elsewhere);
}

TEST_CASE("a task that fails ends the others", "[base]") {
    std::atomic<int> begun{0};
    const auto task = [&](std::size_t i) {
        ++begun;
        if (i == 0) throw std::runtime_error("the first one");
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
    CHECK_THROWS_WITH(base::run_tasks(10000, task), "the first one");
    CHECK(begun < 10000);
}

TEST_CASE("the calling thread polls, and ends the tasks", "[base]") {
    const auto caller = std::this_thread::get_id();
    std::atomic<bool> stop{false};
    int polls = 0;
    const auto task = [&](std::size_t) {
        while (!stop) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
    const auto poll = [&] {
        CHECK(std::this_thread::get_id() == caller);
        if (++polls < 3) return;
        stop = true;
        throw std::runtime_error("enough");
    };
    CHECK_THROWS_WITH(base::run_tasks(100, task, poll), "enough");
    CHECK(polls == 3);
}
