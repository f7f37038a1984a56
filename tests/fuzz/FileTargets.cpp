#include "engine-bridge/calibration/Calibration.h"
#include "engine-bridge/calibration/PointPairs.h"
#include "engine-bridge/hands/HandSource.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/surface/ObjReader.h"
#include "haptics/surface/SurfaceSampler.h"
#include "haptics/surface/TriangleMesh.h"
#include "samples/tools/solve/SolveFiles.h"
#include "tests/engine-bridge/hands/WrittenHands.h"
#include "tests/fuzz/FuzzTargets.h"
#include "tests/fuzz/MemoryFile.h"
#include "tests/fuzz/Require.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

using namespace midair;

namespace
{

std::string textOf(const std::uint8_t* data, std::size_t size)
{
    return std::string(reinterpret_cast<const char*>(data), size);
}

void requireText(const midair::base::InputError& error)
{
    require(*error.what() != '\0', "an error says something");
}

/// Eight transducers, two boards of four.
const haptics::TransducerArray& smallArray()
{
    static const haptics::TransducerArray array = haptics::TransducerArray::fromJson(
        R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 10, "directivity": "point", "boards": [
            {"position_m": [0, -0.1, 0], "normal": [0, 1, 0], "columns": 2, "rows": 2, "pitch_m": 0.01},
            {"position_m": [0, 0.1, 0], "normal": [0, -1, 0], "columns": 2, "rows": 2, "pitch_m": 0.01}]})",
        "fuzz");
    return array;
}

void sampleMesh(const haptics::TriangleMesh& mesh)
{
    try
    {
        haptics::SamplerOptions options;
        options.spacing_m = 0.0085;
        options.maxPoints = 300;
        const haptics::SurfaceSamples samples =
            haptics::sampleSurface(mesh.scaledTo(0.05), options);
        require(samples.positions.allFinite() && samples.normals.allFinite(),
                "points on a surface are finite");
    }
    catch (const midair::base::InputError& error)
    {
        requireText(error);
    }
}

} // namespace

void fuzzObj(const std::uint8_t* data, std::size_t size)
{
    const MemoryFile file(data, size);
    try
    {
        std::vector<std::string> warnings;
        const haptics::TriangleMesh mesh = haptics::readObj(file.path(), &warnings);
        require(mesh.triangles.cols() > 0 && mesh.vertices.allFinite(),
                "a mesh has triangles and its vertices are finite");
        require(mesh.triangles.minCoeff() >= 0 && mesh.triangles.maxCoeff() < mesh.vertices.cols(),
                "triangles refer to vertices that are there");
        require(mesh.intensity.size() == 0 || mesh.intensity.size() == mesh.vertices.cols(),
                "every vertex is painted, or none");
        if (mesh.triangles.cols() <= 64) sampleMesh(mesh);
        std::istringstream plain(haptics::readPlainObj(file.path()).text);
        for (std::string line; std::getline(plain, line);)
            require(line.size() < 4096, "plain lines fit into the buffers of other readers");
    }
    catch (const midair::base::InputError& error)
    {
        requireText(error);
    }
}

void fuzzArray(const std::uint8_t* data, std::size_t size)
{
    try
    {
        const haptics::TransducerArray array =
            haptics::TransducerArray::fromJson(textOf(data, size), "fuzz");
        std::string error;
        require(array.isValid(&error), "an array that was read is valid");
        if (array.size() > 1024) return; // nothing new, only slow
        const haptics::TransducerArray again =
            haptics::TransducerArray::fromJson(array.toJson(), "again");
        require(again.positions == array.positions && again.normals == array.normals &&
                    again.board == array.board && again.frequency_Hz == array.frequency_Hz &&
                    again.drive.amplitudeLevels == array.drive.amplitudeLevels,
                "an array that was read and written reads the same");
    }
    catch (const midair::base::InputError& error)
    {
        requireText(error);
    }
}

void fuzzPoints(const std::uint8_t* data, std::size_t size)
{
    const MemoryFile file(data, size);
    try
    {
        haptics::SolverOptions options;
        options.maxIterations = 3;
        const haptics::ControlPoints points = samples::readControlPoints(file.path());
        require(points.size() > 0 && points.positions.allFinite() && points.targets.allFinite() &&
                    points.normals.allFinite() &&
                    ((points.normals.colwise().norm().array() - 1.0).abs() < 1e-6).all(),
                "points are finite, their normals of unit length");
        if (points.size() > 64) return; // nothing new, only slow
        Eigen::VectorXcf q;
        const haptics::SolveReport report =
            haptics::makeSolver(haptics::solverNames().front(), options)
                ->solve(points, smallArray(), haptics::Medium(), q);
        require(q.size() == smallArray().size() && q.allFinite(), "every transducer is driven");
        require(std::isfinite(report.rms) && std::isfinite(report.level_Pa),
                "what a solver reports is finite");
    }
    catch (const midair::base::InputError& error)
    {
        requireText(error);
    }
}

void fuzzHands(const std::uint8_t* data, std::size_t size)
{
    try
    {
        std::istringstream in(textOf(data, size));
        bridge::RecordedHandSource hands(in, "fuzz", size % 2 == 1);
        double last_s = -1.0;
        for (const bridge::HandFrame& frame : hands.frames())
        {
            require(frame.time_s > last_s && !frame.hands.empty(), "times ascend, with hands");
            last_s = frame.time_s;
        }
        bridge::HandFrame frame;
        for (const double share : {-0.1, 0.0, 0.3, 0.5, 1.0, 1.1, 1e9})
        {
            hands.frameAt(share * hands.duration_s(), frame);
            for (const bridge::HandCapsule& capsule : bridge::handCapsules(frame))
                require(capsule.shape.a.allFinite() && capsule.shape.b.allFinite() &&
                            std::isfinite(capsule.shape.radius_m),
                        "hands are finite at any time");
        }
        std::stringstream written;
        bridge::writeHandRecording(written, hands.frames());
        const bridge::RecordedHandSource again(written, "again");
        require(again.frames().size() <= hands.frames().size(),
                "a recording that was read can be written and read");
    }
    catch (const midair::base::InputError& error)
    {
        requireText(error);
    }
}

void fuzzPairs(const std::uint8_t* data, std::size_t size)
{
    try
    {
        std::istringstream in(textOf(data, size));
        const bridge::PointPairs pairs = bridge::readPointPairs(in, "fuzz");
        require(pairs.world.allFinite() && pairs.array.allFinite() &&
                    pairs.world.cols() == pairs.array.cols(),
                "pairs are finite");
        if (pairs.size() > 40) return; // nothing new, only slow
        const bridge::CalibrationReport report = bridge::calibrate(pairs, {});
        require(!report.text().empty(), "a calibration says how good it is");
        if (!report.usable) return;
        const Eigen::Matrix3d turn = report.worldToArray.linear();
        require(report.worldToArray.matrix().allFinite() &&
                    (turn * turn.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-6 &&
                    turn.determinant() > 0.0,
                "a calibration is rigid");
    }
    catch (const midair::base::InputError& error)
    {
        requireText(error);
    }
}
