// Solvers' arrays are not cleared before they are written: what was there before must not matter.
#include "haptics/base/LargeMemory.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/many/ManyFields.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

/// Leaves only bytes of 0xff (NaN, or -1) in the memory that solvers will get.
void poison()
{
    std::vector<std::pair<void*, std::size_t>> all;
    for (std::size_t bytes = 4096; bytes <= 8U << 20; bytes *= 2)
        for (int k = 0; k < (bytes > 1U << 20 ? 4 : 40); ++k)
        {
            all.emplace_back(base::takeMemory(bytes), bytes);
            std::memset(all.back().first, 0xff, bytes);
        }
    for (const auto& [memory, bytes] : all)
        base::giveMemory(memory, bytes);
}

/// An odd number of points on a sphere, some of them quiet.
ControlPoints points(int n)
{
    ControlPoints all;
    all.positions.resize(3, n);
    all.normals.setZero(3, n);
    all.targets.resize(n);
    for (int l = 0; l < n; ++l)
    {
        const double z = 1.0 - 2.0 * (l + 0.5) / n, r = std::sqrt(1.0 - z * z);
        all.positions.col(l) << 0.03 * r * std::cos(2.4 * l), 0.03 * r * std::sin(2.4 * l),
            0.03 * z;
        all.targets[l] = l % 7 == 3 ? 0.05 : 1.0;
    }
    return all;
}

} // namespace

TEST(UnsetMemory, DoesNotMatterToAnySolver)
{
    for (const int levels : {256, 32})
        for (const std::string& name : solverNames())
        {
            TransducerArray array = TransducerArray::octagonalPrism();
            array.drive.phaseLevels = levels;
            std::vector<Eigen::VectorXcf> fields;
            for (const bool isPoisoned : {false, true})
            {
                if (isPoisoned) poison();
                SolverOptions options;
                options.maxIterations = 12;
                const auto solver = makeSolver(name, options);
                Eigen::VectorXcf q;
                solver->solve(points(31), array, Medium(), q);
                solver->solve(points(33), array, Medium(), q); // the arrays grow
                fields.push_back(q);
            }
            ASSERT_TRUE(fields[1].allFinite()) << name;
            EXPECT_EQ(fields[0], fields[1]) << name << ' ' << levels;
        }
}

TEST(UnsetMemory, DoesNotMatterToManyFields)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    std::vector<double> positions;
    for (int field = 0; field < 6; ++field)
        for (int l = 0; l < 31; ++l)
        {
            const Eigen::Vector3d r =
                points(31).positions.col(l) + Eigen::Vector3d(5e-4 * field, 0.0, 0.0);
            positions.insert(positions.end(), r.data(), r.data() + 3);
        }
    std::vector<std::vector<std::uint8_t>> fields;
    for (const bool isPoisoned : {false, true})
    {
        if (isPoisoned) poison();
        ManyFieldsOptions options;
        options.rmsTolerance = 0.001;
        fields.emplace_back(6 * 3984);
        ManyFields(array, {}, options).solve({6, 31, positions.data()}, fields.back().data());
    }
    EXPECT_EQ(fields[0], fields[1]);
}
