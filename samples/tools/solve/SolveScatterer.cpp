#include "samples/tools/solve/SolveScatterer.h"

#include "haptics/base/InputError.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/scattering/RigidBody.h"
#include "haptics/scattering/ScatteringSolver.h"
#include "haptics/scattering/ThinScreen.h"
#include "haptics/sequence/ReflectorFigures.h"
#include "haptics/surface/ObjReader.h"
#include "samples/tools/solve/SolveFiles.h"
#include "samples/tools/solve/SolveHand.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

constexpr const char* kReflectors = "reflectors";

using Things = std::vector<std::shared_ptr<const haptics::Scatterer>>;

/// The fields that have points, and these.
struct Played
{
    explicit Played(const haptics::FieldSequence& sequence)
    {
        for (std::size_t k = 0; k < sequence.fields.size(); ++k)
        {
            const haptics::ControlPoints& part =
                sequence.parts[std::min(k, sequence.parts.size() - 1)];
            if (part.size() == 0 || sequence.fields[k].isZero(0.0f)) continue;
            points.push_back(part.positions);
            fields.push_back(sequence.fields[k]);
        }
    }

    std::vector<Eigen::Matrix3Xd> points;
    std::vector<Eigen::VectorXcf> fields;
};

void addRectangle(const haptics::Reflector& one, haptics::TriangleMesh& shape)
{
    const auto first = static_cast<int>(shape.vertices.cols());
    shape.vertices.conservativeResize(3, first + 4);
    for (int k = 0; k < 4; ++k)
        shape.vertices.col(first + k) = one.position +
                                        ((k & 1) - 0.5) * one.size_m.x() * one.along +
                                        ((k >> 1) - 0.5) * one.size_m.y() * one.across();
    const Eigen::Index last = shape.triangles.cols();
    shape.triangles.conservativeResize(3, last + 2);
    shape.triangles.col(last) = Eigen::Vector3i(first, first + 1, first + 3);
    shape.triangles.col(last + 1) = Eigen::Vector3i(first, first + 3, first + 2);
}

/// Returns the screens, and takes them from the reflectors of \a array.
Things screensOf(haptics::TransducerArray& array, double wavelength_m, haptics::TriangleMesh& shape)
{
    Things screens;
    std::vector<haptics::Reflector> others;
    for (const haptics::Reflector& one : array.reflectors)
        if (const auto plate = haptics::plateOf(one))
        {
            screens.push_back(std::make_shared<haptics::ThinScreen>(*plate, wavelength_m));
            addRectangle(one, shape);
        }
        else
            others.push_back(one);
    if (screens.empty())
        throw base::InputError("no reflector has ends, a reflection of 1 and no phase of its own");
    array.reflectors = std::move(others);
    return screens;
}

void say(const std::string& what)
{
    std::fprintf(stderr, "midair-solve: body: %s\n", what.c_str());
}

/// Returns $XDG_CACHE_HOME/osgMidair, or ~/.cache/osgMidair; empty: there is neither. Relative
/// paths don't count (XDG Base Directory Specification).
std::filesystem::path cacheFolder()
{
    const std::filesystem::path given = base::userVariable("XDG_CACHE_HOME").value_or(""),
                                home = base::userVariable("HOME").value_or("");
    if (given.is_absolute()) return given / "osgMidair";
    return home.is_absolute() ? home / ".cache" / "osgMidair" : std::filesystem::path();
}

/// Returns a function that says each tenth, once a second has passed.
std::function<void(double)> progressTold()
{
    using Clock = std::chrono::steady_clock;
    return [begin = Clock::now(), tenths = 0](double share) mutable
    {
        const int now = static_cast<int>(10.0 * share);
        if (now <= tenths || Clock::now() - begin < std::chrono::seconds(1)) return;
        tenths = now;
        say(fmt::format("{} %", 10 * now));
    };
}

std::shared_ptr<haptics::RigidBody>
rigidOf(haptics::ClosedBody body, const SolveArguments& arguments, double wavelength_m)
{
    say(fmt::format(
        "{} triangles, {:.0f} MB", body.size(), 1e-6 * haptics::RigidBody::bytesFor(body.size())));
    haptics::BodyMaking making;
    making.threads = arguments.settings.threads;
    if (!arguments.noCache) making.cache.folder = cacheFolder();
    making.cache.told = say;
    making.progress = progressTold();
    return std::make_shared<haptics::RigidBody>(std::move(body), wavelength_m, making);
}

/// Returns where the index fingertip of a hand is the lowest, m.
Eigen::Vector3d
padFor(const SolveArguments& arguments, const bridge::SolveTask& task, const Eigen::Vector3d& up)
{
    const std::vector<double>& given = arguments.scattererAt_m;
    if (!given.empty()) return {given[0], given[1], given[2]};
    haptics::ControlPoints all;
    for (const haptics::ControlPoints& set : task.sets)
        append(all, set);
    if (all.size() == 0)
        throw base::InputError("there is no point that it could stand above; use --scatterer-at");
    return padAbove(all.positions, up);
}

Things handOf(const SolveArguments& arguments, const bridge::SolveTask& task, Solution& solution)
{
    const Eigen::Vector3d up = openSideOf(solution.scene.array), pad = padFor(arguments, task, up);
    const double wavelength_m = solution.scene.wavelength_m();
    solution.scatterer = handMesh(arguments.scattererElements);
    haptics::ClosedBody body = haptics::ClosedBody::from(solution.scatterer,
                                                         std::numeric_limits<double>::infinity(),
                                                         haptics::RigidBody::kMostElements);
    const double elements = wavelength_m / body.meanSide_m(),
                 error = haptics::RigidBody::expectedError(elements);
    solution.scattererTold = fmt::format(
        "a right hand, its index fingertip at {:.1f}, {:.1f}, {:.1f} mm; {:.1f} "
        "elements a wavelength: {}",
        1e3 * pad.x(),
        1e3 * pad.y(),
        1e3 * pad.z(),
        elements,
        error < 1.0 ? fmt::format("3 mm off it {:.0f} % of the field may be wrong", 100.0 * error)
                    : "too few to be right");
    say(solution.scattererTold);
    // Made at rest: one matrix in the cache is that of all its places.
    const auto hand = rigidOf(std::move(body), arguments, wavelength_m);
    const Eigen::Isometry3d pose = pointingAt(pad, up);
    hand->moveBy(pose);
    solution.scatterer.vertices = pose * solution.scatterer.vertices;
    return {hand};
}

/// Sets the shape of \a solution, and takes screens from the reflectors of \a array.
Things thingsOf(const SolveArguments& arguments,
                const bridge::SolveTask& task,
                haptics::TransducerArray& array,
                Solution& solution)
{
    const double wavelength_m = solution.scene.wavelength_m();
    if (arguments.scattererFile == kReflectors)
        return screensOf(array, wavelength_m, solution.scatterer);
    if (arguments.scattererFile == kScatteringHand) return handOf(arguments, task, solution);
    solution.scatterer = haptics::readObj(arguments.scattererFile);
    return {rigidOf(
        haptics::RigidBody::divided(solution.scatterer, wavelength_m), arguments, wavelength_m)};
}

/// Returns why \a solution can't be corrected for what stands in it; empty: it can.
std::string whyUncorrectable(const SolveArguments& arguments, const Solution& solution)
{
    if (arguments.noCorrection) return "--no-correction";
    if (arguments.outline) return "outlines are solved for the array alone";
    if (solution.sequence.evened) return "evened fields are made for the surface, not for points";
    if (solution.parts.reflectors && !solution.parts.reflectors->isCorrected)
        return "a correction for the reflectors would not gain";
    if (!(solution.sequence.report.level_Pa > 0.0)) return "the field is silent";
    return {};
}

bridge::SolvedFields corrected(bridge::SolveTask task,
                               const std::shared_ptr<haptics::ScatteredField>& truth)
{
    task.makeSolver = [truth](const std::string& name, const haptics::SolverOptions& options)
    {
        const auto told = [](int round, double rms)
        {
            std::fprintf(stderr,
                         "midair-solve: rms %.3f %% with the scatterer, corrected %d times\n",
                         100.0 * rms,
                         round);
        };
        return std::make_unique<haptics::ScatteringSolver>(
            haptics::makeSolver(name, options), truth, told);
    };
    return bridge::solveOnce(task);
}

void take(bridge::SolvedFields other,
          const SolveArguments& arguments,
          const bridge::SolveTask& task,
          Solution& solution)
{
    static_cast<bridge::SolvedFields&>(solution) = std::move(other);
    if (!solution.parts.reflectors) return;
    SolvedReflectors& reflectors = *solution.parts.reflectors;
    reflectors.played = haptics::reflectorFigures(
        solution.sequence, task.array, task.medium, arguments.settings.threads);
    solution.sequence.report.reflectorRms = reflectors.played.expectedRms;
    haptics::TransducerArray free = task.array;
    free.reflectors.clear();
    reflectors.freeEars_dB = solution.ears->levelOf_dB(free, task.medium, solution.sequence.fields);
}

/// Throws what \a does throws, with the name of the file.
template<typename Does>
auto named(const SolveArguments& arguments, const Does& does)
{
    try
    {
        return does();
    }
    catch (const base::InputError& error)
    {
        throw base::InputError("--scatterer " + arguments.scattererFile + ": " + error.what());
    }
}

} // namespace

void loadScatterer(const SolveArguments& arguments,
                   const bridge::SolveTask& task,
                   Solution& solution)
{
    if (arguments.scattererFile.empty()) return;
    named(arguments,
          [&]
          {
              haptics::TransducerArray array = solution.scene.array;
              Things things = thingsOf(arguments, task, array, solution);
              solution.truth =
                  std::make_shared<haptics::ScatteredField>(std::move(things),
                                                            std::move(array),
                                                            solution.scene.medium,
                                                            arguments.settings.threads);
          });
    solution.scattered_Pa =
        [truth = solution.truth](const Eigen::Matrix3Xd& places, const Eigen::VectorXcf& q)
    {
        truth->setDrive(q);
        Eigen::VectorXf p_Pa =
            (truth->free_Pa(places) + truth->scattered_Pa(places)).cwiseAbs().cast<float>();
        for (Eigen::Index l = 0; l < places.cols(); ++l)
            if (truth->isInside(places.col(l))) p_Pa[l] = 0.0f;
        return p_Pa;
    };
}

void correctForScatterer(const SolveArguments& arguments,
                         const bridge::SolveTask& task,
                         Solution& solution)
{
    SolvedScatterer& told = solution.parts.scatterer.emplace();
    told.what = solution.scattererTold;
    told.uncorrectedRms = solution.sequence.report.rms;
    told.uncorrectedLevel_Pa = solution.sequence.report.level_Pa;
    told.whyUncorrected = whyUncorrectable(arguments, solution);
    if (told.whyUncorrected.empty())
    {
        bridge::SolvedFields other = corrected(task, solution.truth);
        const double rms = other.sequence.report.rms;
        if (other.sequence.report.level_Pa > 0.0 && rms < told.uncorrectedRms)
            take(std::move(other), arguments, task, solution);
        else
            told.whyUncorrected = "a correction doesn't gain";
    }
    told.rms = solution.sequence.report.rms;
    told.level_Pa = solution.sequence.report.level_Pa;
    const Played played(solution.sequence);
    told.change =
        named(arguments,
              [&] { return haptics::scatteringOf(*solution.truth, played.points, played.fields); });
}

void writeScattering(const std::string& path, const Solution& solution)
{
    TextFile file(path);
    file.line("field,x_m,y_m,z_m,with_re_Pa,with_im_Pa,free_re_Pa,free_im_Pa");
    const Played played(solution.sequence);
    const haptics::ScatteringFigures& change = solution.parts.scatterer->change;
    for (std::size_t k = 0; k < change.with_Pa.size(); ++k)
        for (Eigen::Index l = 0; l < change.with_Pa[k].size(); ++l)
            file.line("{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}",
                      k + 1,
                      played.points[k](0, l),
                      played.points[k](1, l),
                      played.points[k](2, l),
                      change.with_Pa[k][l].real(),
                      change.with_Pa[k][l].imag(),
                      change.free_Pa[k][l].real(),
                      change.free_Pa[k][l].imag());
    file.finish();
}

void printScattering(const SolvedScatterer& some)
{
    const haptics::ScatteringFigures& change = some.change;
    std::printf("scatterer   the points change by %.2f %% rms, at most %.2f %%; level %.1f %% (%ld "
                "elements, %d iterations)\n",
                100.0 * change.rms,
                100.0 * change.worst,
                100.0 * change.level,
                static_cast<long>(change.elements),
                change.iterations);
    if (!some.what.empty()) std::printf("            %s\n", some.what.c_str());
    if (some.whyUncorrected.empty())
        std::printf(
            "            solved for: rms %.3f %%, level %.0f Pa; rms %.3f %%, level %.0f Pa "
            "without a correction\n",
            100.0 * some.rms,
            some.level_Pa,
            100.0 * some.uncorrectedRms,
            some.uncorrectedLevel_Pa);
    else
        std::printf("            not solved for (%s): rms %.3f %%\n",
                    some.whyUncorrected.c_str(),
                    100.0 * some.rms);
    if (change.residual > haptics::RigidBody::kResidual)
        std::printf("note        the scatterer's equations are solved to %.2g only\n",
                    change.residual);
}

} // namespace midair::samples
