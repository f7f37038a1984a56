#include "samples/tools/sense/SensePlayback.h"

#include "haptics/base/InputError.h"
#include "samples/tools/sense/SensePlace.h"

#include <osgMidair/ArrayState>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <midair.h>

namespace midair::samples
{

namespace
{

void require(midair_status status)
{
    if (status < 0) throw base::InputError(midair_last_error());
}

/// Returns the text that \a get writes.
template<typename Get>
std::string textOf(Get&& get)
{
    std::size_t needed = 0;
    if (get(nullptr, 0, &needed) < 0 && needed == 0) return {};
    std::string text(needed, '\0');
    if (get(text.data(), text.size(), nullptr) < 0) return {};
    text.resize(std::min(text.find('\0'), text.size()));
    return text;
}

Eigen::Matrix4d placeOf(const midair_array* array, const std::optional<Eigen::Vector3d>& place_m)
{
    std::size_t count = 0;
    require(midair_array_size(array, &count));
    std::vector<midair_transducer> all(count);
    require(midair_array_transducers(array, all.data(), all.size()));
    Eigen::Matrix3Xd positions(3, static_cast<Eigen::Index>(count));
    Eigen::Matrix3Xd normals(3, positions.cols());
    for (std::size_t k = 0; k < count; ++k)
    {
        const auto column = static_cast<Eigen::Index>(k);
        positions.col(column) = Eigen::Map<const Eigen::Vector3d>(all[k].position);
        normals.col(column) = Eigen::Map<const Eigen::Vector3d>(all[k].normal);
    }
    Eigen::Matrix4d place = patternPlace(positions, normals);
    if (place_m) place.topRightCorner<3, 1>() = *place_m;
    return place;
}

static_assert(MIDAIR_JOINTS == SenseHand::kJoints);

/// None if a joint isn't known.
std::optional<SenseHand> senseHand(const midair_hand& from, const Eigen::Isometry3d& toPattern)
{
    constexpr int kLeft = 0;
    SenseHand hand;
    hand.isLeft = from.id == kLeft;
    for (int j = 0; j < SenseHand::kJoints; ++j)
    {
        const midair_joint& joint = from.joints[j];
        if (joint.position_valid == 0) return {};
        hand.joints.col(j) = toPattern * Eigen::Vector3d::Map(joint.position);
        hand.radii_m[j] = joint.radius_m;
    }
    if (from.joints[0].orientation_valid == 0) return {};
    const Eigen::Quaterniond turn(
        Eigen::Vector4d(Eigen::Vector4d::Map(from.joints[0].orientation)));
    hand.turn = toPattern.linear() * turn.toRotationMatrix();
    return hand;
}

} // namespace

struct SensePlayback::Scene
{
    Scene(const SensePlaybackOptions& wanted, std::function<void(const std::string&)> teller) :
        options(wanted),
        tell(std::move(teller))
    {
        try
        {
            require(midair_array_load(options.array.c_str(), &array));
            require(midair_scene_make(array, &scene));
            place = placeOf(array, options.place_m);
            require(midair_on_message(scene, &Scene::receive, this));
            if (!options.hands.empty()) require(midair_open_hands(scene, options.hands.c_str()));
            require(midair_play(scene, options.device.c_str()));
        }
        catch (...)
        {
            close();
            throw;
        }
    }
    ~Scene() { close(); }
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    void close()
    {
        midair_scene_close(scene);
        midair_array_close(array);
        scene = nullptr;
        array = nullptr;
    }

    static void receive(void* user, const midair_message* message, const char* text)
    {
        // A condition that has ended is told by what follows it.
        if (message->until_s == 0.0 || message->active == 1)
            static_cast<Scene*>(user)->tellOnce(text);
    }
    void tellOnce(const std::string& text)
    {
        if (told.insert(text).second) tell(text);
    }

    void set(const char* name, const std::string& value) const
    {
        require(midair_object_set(scene, object, name, value.c_str()));
    }
    /// The pattern's frame, in the array's.
    Eigen::Isometry3d frame() const
    {
        return Eigen::Isometry3d(place) * Eigen::Translation3d(0.0, 0.0, -options.height_m);
    }
    void setPose() const
    {
        const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> pose = frame() * transform;
        require(midair_set_pose(scene, object, pose.data()));
    }
    void remove()
    {
        midair_remove(scene, object);
        object = 0;
        parameters = "";
    }
    midair_device_state state() const
    {
        midair_device_state now{};
        midair_state(scene, &now);
        return now;
    }

    SensePlaybackOptions options;
    std::function<void(const std::string&)> tell;
    std::set<std::string> told;
    midair_array* array = nullptr;
    midair_scene* scene = nullptr;
    midair_object object = 0; ///< 0: no pattern so far
    Eigen::Matrix4d place = Eigen::Matrix4d::Identity();
    Eigen::Matrix4d transform = Eigen::Matrix4d::Identity();
    /// As they were set last; none: a new pattern may have changed them.
    std::optional<std::string> parameters = "";
    bool isTracking = false;
    int plays = 0; ///< how often it was begun
};

SensePlayback::SensePlayback(const SensePlaybackOptions& options,
                             std::function<void(const std::string&)> tell) :
    _scene(std::make_unique<Scene>(options, std::move(tell)))
{
}

SensePlayback::~SensePlayback() = default;

void SensePlayback::setSensation(const std::string& sensation)
{
    Scene& of = *_scene;
    if (of.object != 0)
    {
        of.parameters.reset();
        return of.set("sensation", sensation);
    }
    require(midair_add_sensation(of.scene, sensation.c_str(), &of.object));
    try
    {
        of.set("trigger", "program");
        of.set("plays", "0");
        of.set("pressure", fmt::format("{} Pa", of.options.pressure_Pa));
        of.set("seed", fmt::format("{}", of.options.seed));
        of.set("attach", of.isTracking ? "hand:palm" : "place");
        of.setPose();
    }
    catch (...)
    {
        of.remove();
        throw;
    }
}

void SensePlayback::setParameters(const SenseParameters& parameters)
{
    std::string text;
    for (const auto& [name, value] : parameters)
        if (name.find_first_of("=;") != std::string::npos)
            _scene->tellOnce(
                fmt::format("the parameter \"{}\" can't be set, as its name has = or ;", name));
        else
            text += fmt::format("{}{}={}", text.empty() ? "" : "; ", name, value);
    if (_scene->object == 0 || text == _scene->parameters) return;
    _scene->set("parameters", text);
    _scene->parameters = text;
}

void SensePlayback::setTransform(const Eigen::Matrix4d& transform)
{
    const Eigen::Matrix4d before = std::exchange(_scene->transform, transform);
    try
    {
        if (_scene->object != 0) _scene->setPose();
    }
    catch (...)
    {
        _scene->transform = before;
        throw;
    }
}

void SensePlayback::setTracking(bool isTracking)
{
    if (isTracking && _scene->options.hands.empty())
    {
        _scene->tellOnce("a pattern on the hand needs --hands; it is played in its place");
        isTracking = false;
    }
    if (isTracking == _scene->isTracking) return;
    if (_scene->object != 0) _scene->set("attach", isTracking ? "hand:palm" : "place");
    _scene->isTracking = isTracking;
}

void SensePlayback::begin()
{
    if (_scene->object == 0) throw base::InputError("there is no pattern to play");
    _scene->set("plays", std::to_string(_scene->plays + 1));
    ++_scene->plays;
}

void SensePlayback::end()
{
    if (_scene->object == 0) return;
    if (midair_object_set(_scene->scene, _scene->object, "plays", "0") >= 0) return;
    _scene->tellOnce(midair_last_error());
    _scene->remove(); // silent all the same
}

std::optional<SenseHand> SensePlayback::hand() const
{
    std::array<midair_hand, 8> all{};
    std::size_t count = 0;
    midair_last_hands(_scene->scene, all.data(), all.size(), &count);
    const Eigen::Isometry3d toPattern = _scene->frame().inverse();
    for (std::size_t k = 0; k < std::min(count, all.size()); ++k)
        if (auto hand = senseHand(all[k], toPattern)) return hand;
    return {};
}

void SensePlayback::update(double time_s)
{
    if (midair_update(_scene->scene, time_s) < 0) _scene->tellOnce(midair_last_error());
}

bool SensePlayback::isOpening() const
{
    return _scene->state().state == MIDAIR_STATE_OPENING;
}

bool SensePlayback::isOpen() const
{
    const int state = _scene->state().state;
    return state != MIDAIR_STATE_CLOSED && state != MIDAIR_STATE_OPENING;
}

bool SensePlayback::isWorking() const
{
    const int state = _scene->state().state;
    return state == MIDAIR_STATE_SILENT || state == MIDAIR_STATE_PLAYING ||
           state == MIDAIR_STATE_MUTED;
}

std::string SensePlayback::status() const
{
    const midair_device_state now = _scene->state();
    const std::string line =
        textOf([this](char* text, std::size_t size, std::size_t* needed)
               { return midair_device_status(_scene->scene, text, size, needed); });
    return fmt::format("{}: {} fields played; {}",
                       bridge::stateName(static_cast<bridge::ArrayState>(now.state)),
                       now.played,
                       line);
}

const Eigen::Matrix4d& SensePlayback::place() const
{
    return _scene->place;
}

void SensePlayback::mute()
{
    midair_mute(_scene->scene, 1);
}

} // namespace midair::samples
