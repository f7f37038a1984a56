// How a HapticEngine waits for fields, reports them, and solves at once.
#include "engine-bridge/PoseAndStretch.h"
#include "engine-bridge/player/PipelineMaker.h"
#include "engine-bridge/player/SceneOptions.h"
#include "engine-bridge/player/SceneSolve.h"
#include "engine-bridge/scene/Convert.h"
#include "engine-bridge/solving/ArrayLevels.h"
#include "haptics/base/InputError.h"
#include "haptics/base/ThrownBy.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/settings/UserOptions.h"

#include <utility>

namespace osgMidair
{

using midair::base::Message;
using midair::base::MessageCode;
using midair::bridge::SceneSolve;

void HapticEngine::setFieldCallback(FieldCallback* callback)
{
    _told.fieldCallback = callback;
    lookNext();
}

// A callback may do anything, so it is called last.
void HapticEngine::tellField()
{
    const osg::ref_ptr<FieldCallback> keep = _told.fieldCallback;
    if (!keep) return;
    const osg::ref_ptr<const HapticField> newest = field();
    if (!newest || newest == _told.field) return;
    _told.field = newest;
    const std::string thrown = midair::base::thrownBy([&] { keep->solved(*newest); });
    if (!thrown.empty())
        say({MessageCode::CALLBACK_THREW, "the field callback has thrown " + thrown});
}

osg::ref_ptr<const HapticField> HapticEngine::awaitField(double timeout_s, std::string& error) const
{
    error = _player->awaitField(timeout_s);
    return error.empty() ? field() : nullptr;
}

// Returns grantedSettings(); throws the reason if nothing may be played.
HapticSettings HapticEngine::solvable()
{
    std::vector<Message> messages;
    HapticSettings settings = Environment::restrict(usable(messages));
    _player->log().sayNow({MessageCode::SETTINGS_INVALID}, messages);
    if (settings.isSilenced)
        throw midair::base::InputError(settings.whySilenced.empty() ? "isSilenced is set"
                                                                    : settings.whySilenced.front());
    if (!settings.enabled) throw midair::base::InputError("the scene is disabled");
    // The thermometer's reading is that of the air during playback.
    if (_settings.isRead && !settings.temperatureSource.empty())
        settings.temperature = _player->playedSettings().temperature;
    return settings;
}

SceneSolve HapticEngine::solveInput(const SceneRoot& root)
{
    const HapticSettings settings = solvable();
    SceneSolve input;
    if (!setPlaces(settings))
        throw midair::base::InputError("calibration is not rigid (a scene unit is set by "
                                       "metresPerUnit)");
    _collector.configure(_places.toArray, settings.shadows);
    // The next frame rebuilds what update() has collected.
    _collector.forget();
    collectWhole(root, input.snapshot.objects);
    _collector.forget();
    fillSnapshot(input.snapshot, settings.metresPerUnit);
    input.snapshot.around.reach_m = settings.reach;
    input.snapshot.around.shadows = settings.shadows;
    input.snapshot.around.hands = midair::bridge::handCapsules(_player->hands().frame());
    addRealThings(input.snapshot);
    listen(input.snapshot.ears, settings.earCamera);
    if (!input.snapshot.ears.allFinite())
        throw midair::base::InputError("an ear is at a place that is not finite");
    const midair::bridge::SceneSettings& own = settings;
    input.settings = midair::bridge::restricted(own, innerLimits());
    auto array = midair::bridge::arrayOn(playedOn(settings), settings.dead, settings.weak);
    midair::bridge::keepToSignal(array.drive);
    input.array = std::make_shared<const midair::haptics::TransducerArray>(std::move(array));
    return input;
}

osg::ref_ptr<const HapticField> HapticEngine::solve(const SceneRoot& root, std::string& error)
{
    try
    {
        const SceneSolve input = solveInput(root);
        midair::base::MessageLog messages;
        midair::bridge::SolvedScene solved = midair::bridge::solveScene(input, messages);
        for (Message& message : messages.messages())
        {
            message.isActive = false; // it concerns only this solve
            _player->log().take(message);
        }
        auto result = std::make_shared<midair::bridge::HologramResult>();
        result->worldToArray = _places.toArray;
        result->array = std::move(solved.array);
        result->medium = solved.medium;
        result->sequence = std::move(solved.fields.sequence);
        result->points = std::move(solved.fields.points);
        result->achieved_Pa = solved.fields.achieved_Pa.cast<float>();
        for (const midair::bridge::HapticObject& object : input.snapshot.objects)
            result->origins.push_back(object.origin);
        const midair::haptics::SolveReport& report = result->report();
        error.clear();
        if (midair::bridge::isSilent(report.stop))
            error = report.message.empty() ? "there are no control points" : report.message;
        return publicForm(std::move(result));
    }
    catch (...)
    {
        error = midair::base::whatWasThrown();
        return nullptr;
    }
}

} // namespace osgMidair
