#include "engine-bridge/pipeline/ScatteringStage.h"

#include "haptics/base/ThrownBy.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/scattering/ThinScreen.h"
#include "haptics/sequence/FieldOrder.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

constexpr int kHeldSet = 0;        // the composer's set of held fields
constexpr double kLook_s = 0.02;   // time between two looks at the other thread
constexpr double kBelowCap = 0.99; // of the cap: drive levels round up by half a percent

/// The share of its amplitudes at which \a q, which reaches \a highest_Pa, stays below \a cap_Pa.
double shareBelow(double cap_Pa, double highest_Pa, const Eigen::VectorXcf& q)
{
    if (!(cap_Pa > 0.0) || !(highest_Pa > kBelowCap * cap_Pa)) return 1.0;
    return std::min(1.0, q.cwiseAbs().maxCoeff() * kBelowCap * cap_Pa / highest_Pa);
}

/// Returns \a played, which caps may have lowered, with the largest amplitude and the common phase
/// of \a q, a drive near it.
Eigen::VectorXcf sizedAs(const Eigen::VectorXcf& q, const Eigen::VectorXcf& played)
{
    const float most = played.cwiseAbs().maxCoeff();
    const std::complex<float> along = played.dot(q);
    if (!(most > 0.0F) || !(std::abs(along) > 0.0F)) return q;
    return played * (q.cwiseAbs().maxCoeff() / most * along / std::abs(along));
}

} // namespace

ScatteringStage::ScatteringStage(PipelineContext& context,
                                 const haptics::SequenceComposer& composer,
                                 const CappedOutput& output,
                                 HandStage& hands,
                                 const RestRefiner& refiner,
                                 const LouderStage& louder) :
    _context(context),
    _composer(composer),
    _output(output),
    _hands(hands),
    _refiner(refiner),
    _louder(louder)
{
}

std::unique_ptr<ScatteringStage::Worker> ScatteringStage::makeWorker()
{
    const auto scattering = std::make_shared<haptics::RestScattering>();
    return std::make_unique<Worker>(
        [scattering](const Request& request)
        {
            auto answer = std::make_unique<Answer>();
            answer->frame = request.frame;
            try
            {
                answer->field = scattering->solve(request.field);
            }
            catch (...)
            {
                answer->field = {};
                answer->field.why = base::whatWasThrown();
            }
            return answer;
        });
}

// Leaves the other thread's work, and what was told of it.
void ScatteringStage::stop()
{
    _stop.request();
    tell("");
}

void ScatteringStage::end()
{
    stop();
    _work = Work::NONE;
}

void ScatteringStage::setOptions()
{
    end();
}

// By a stage at rest before this one, whose turn then is later.
void ScatteringStage::replace()
{
    if (!_isOwn)
    {
        stop();
        if (_work != Work::BEGIN) _work = Work::NONE;
    }
    _isOwn = false;
}

// The faces of a closed body aren't sheets: their full waves are those of the body.
haptics::RigidThings ScatteringStage::things() const
{
    haptics::RigidThings things;
    things.bodies = _context.bodies;
    for (const haptics::Reflector& one : _context.options.array.reflectors)
    {
        const auto face =
            std::find_if(_context.faces.begin(),
                         _context.faces.end(),
                         [&](const haptics::FlatFace& other) { return other.rectangle == one; });
        if (face != _context.faces.end() && face->isOfBody)
        {
            if (face->isSolvedAtRest) things.faces.push_back(one);
        }
        else if (haptics::plateOf(one))
            things.plates.push_back(one);
    }
    return things;
}

bool ScatteringStage::canBeCorrected(const HologramResult& result) const
{
    if (_context.bodies.empty() && _context.options.array.reflectors.empty()) return false;
    const std::vector<std::string> solvers = haptics::solverNames();
    return result.playing && result.foci == 0 && result.points.size() > 0 &&
           result.sequence.isHeld() && !result.sequence.evened && !result.outline &&
           !result.sequence.outside && result.sequence.parts.size() == 1 &&
           _context.options.cycle == 1 && _context.options.even > 0 &&
           std::isfinite(_context.options.restAfter_s) && _context.options.restAfter_s > 0.0 &&
           std::count(solvers.begin(), solvers.end(), _context.options.solver) > 0 &&
           !things().isEmpty();
}

void ScatteringStage::settle(const HologramResult& result,
                             const SceneSnapshot& /*snapshot*/,
                             const haptics::TransducerArray& /*array*/)
{
    _work = canBeCorrected(result) ? Work::BEGIN : Work::NONE;
    _due_s = _context.clock.now_s() + _context.options.restAfter_s;
}

bool ScatteringStage::hasTurn(bool isPlaying) const
{
    return isPlaying && _work != Work::NONE && !_refiner.rest_s(isPlaying) &&
           !_louder.rest_s(isPlaying);
}

std::optional<double> ScatteringStage::rest_s(bool isPlaying) const
{
    if (!hasTurn(isPlaying)) return std::nullopt;
    return std::max(0.0, _due_s - _context.clock.now_s());
}

RestStep ScatteringStage::attend(bool isPlaying)
{
    RestStep made;
    if (!hasTurn(isPlaying) || _context.clock.now_s() < _due_s) return made;
    try
    {
        if (_work == Work::BEGIN)
            begin();
        else if (_work == Work::WALK)
            made.field = walk();
        else if (const auto answer = _worker->take(); answer && answer->frame == _asked)
            take(*answer);
        else
            _due_s = _context.clock.now_s() + kLook_s;
    }
    catch (const base::Stopped&)
    {
        throw; // not an error: the step can be repeated
    }
    catch (...)
    {
        end();
        _context.messages.say({base::MessageCode::FIELD_REST, base::whatWasThrown()});
    }
    _isOwn = made.isOtherField = made.field.has_value();
    return made;
}

void ScatteringStage::begin()
{
    const HologramResult& last = *_context.last;
    Eigen::VectorXcf c = _composer.multipliers(kHeldSet);
    if (!canBeCorrected(last) || c.size() != last.points.size()) return end();
    haptics::RigidThings some = things();
    const auto size = haptics::RestScattering::sizeOf(some, _context.options.wavelength_m());
    const std::size_t count = some.plates.size() + some.bodies.size();
    Request request;
    request.frame = ++_asked;
    request.field = {last.points,
                     _hands.shadowed(last.points),
                     *last.array,
                     std::move(some),
                     _context.options.medium,
                     _context.options.solver,
                     _context.options.solverOptions,
                     std::move(c)};
    _stop = {};
    request.field.options.stop = _stop.token();
    request.field.options.pool.reset(); // it is the playing solver's
    request.field.options.threads = 1;
    request.field.options.skipTolerance = 0.0;
    if (!_worker) _worker = makeWorker();
    _worker->submit(std::move(request));
    _work = Work::SOLVE;
    tell(fmt::format("the field is being solved for the full waves of {} thing{} ({:.0f} elements, "
                     "{:.0f} MB)",
                     count,
                     count == 1 ? "" : "s",
                     size.elements,
                     1e-6 * size.bytes));
}

void ScatteringStage::take(const Answer& answer)
{
    const haptics::FieldForThings& found = answer.field;
    if (found.drive.size() == 0)
    {
        end();
        return tell("the field isn't solved for the full waves of what stands there: " + found.why);
    }
    const HologramResult& last = *_context.last;
    _corrected = last.sequence;
    _corrected.achieved_Pa.resize(0);
    _corrected.outside = std::make_shared<haptics::OutsideField>(found.outside);
    _corrected.most = shareBelow(_output.maxPressure_Pa(), found.highest_Pa, found.drive);
    _corrected.report = found.report;
    _corrected.report.capFactor = 1.0;
    const Eigen::VectorXcf from = sizedAs(found.drive, last.played());
    _image_Pa = rate(from, _corrected);
    _walk.begin(from, found.drive, {});
    _work = Work::WALK;
    tell(fmt::format(
        "the field is solved for the full waves of what stands there: rms {:.3f} %, {:.3f} % "
        "before",
        100.0 * found.report.rms,
        100.0 * found.rmsBefore));
}

// Makes \a next the field \a q and rates it. Returns its level with images alone.
double ScatteringStage::rate(const Eigen::VectorXcf& q, haptics::FieldSequence& next) const
{
    const haptics::SolverOptions& options = _context.options.solverOptions;
    const haptics::ControlPoints& points = next.parts.front();
    const Eigen::VectorXcf p = haptics::pressureAt(points.positions,
                                                   *_context.last->array,
                                                   _context.options.medium,
                                                   q,
                                                   options.threads,
                                                   options.stop);
    next.fields = {q};
    haptics::rateLevel(points, p.cwiseAbs(), next.report);
    const double image_Pa = next.report.level_Pa;
    const Eigen::VectorXcf beyond = next.outside->at(q).cast<std::complex<float>>();
    haptics::rateLevel(points, (p + beyond).cwiseAbs(), next.report);
    return image_Pa;
}

// Returns the next field, if it keeps the bounds of the walk. Levels are compared with images
// alone, as what is beyond them is known for the last field, and only nearly before it.
std::optional<haptics::FieldSequence> ScatteringStage::walk()
{
    haptics::FieldSequence next = _corrected;
    Eigen::VectorXcf q = _walk.next();
    haptics::roundPhases(q, _context.options.array.drive);
    const double image_Pa = rate(q, next), ratio = image_Pa / _image_Pa;
    haptics::continueFrom(_context.last->played(),
                          _context.options.solverOptions.updateRate_Hz,
                          _context.options.array.drive,
                          next);
    const bool isSmall = _walk.accept(next.report.meanPhaseStep_rad, std::max(ratio, 1.0 / ratio));
    if (_walk.isOver()) _work = Work::NONE;
    if (!isSmall) return std::nullopt;
    _image_Pa = image_Pa;
    ++_context.counters.walked;
    _due_s = _context.clock.now_s() + kWalkPace_s;
    return next;
}

void ScatteringStage::tell(const std::string& text)
{
    std::vector<base::Message> told;
    if (!text.empty()) told.emplace_back(base::MessageCode::REFLECTOR_SOLVED, text);
    _context.messages.sayNow({base::MessageCode::REFLECTOR_SOLVED}, told);
}

} // namespace midair::bridge
