// midair.Scene and midair.Object.
#include "engine-bridge/python/Bindings.h"

#include <algorithm>
#include <optional>
#include <set>
#include <vector>

#include <pybind11/stl.h>

namespace midair::python
{

namespace
{

using Indices = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;
using Hands = py::array_t<midair_hand, py::array::c_style>;
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// The open scenes; guarded by the GIL.
std::set<PyScene*>& openScenes()
{
    static auto* const all = new std::set<PyScene*>;
    return *all;
}

/// Names of midair_device_state.state, the same in all languages.
constexpr const char* kStates[] = {
    "closed", "opening", "silent", "playing", "muted", "lost", "fault"};

/// midair.Object: keeps its scene.
struct PyObjectOfScene
{
    std::shared_ptr<PyScene> scene;
    midair_object number = 0;
};

std::shared_ptr<PyScene> makeScene(const py::object& given)
{
    const auto array =
        py::isinstance<PyArray>(given) ? given.cast<std::shared_ptr<PyArray>>() : loadArray(given);
    midair_scene* scene = nullptr;
    checked(midair_scene_make, array->get(), &scene);
    std::shared_ptr<PyScene> owned(new PyScene(scene, array->name),
                                   [](PyScene* one)
                                   {
                                       openScenes().erase(one);
                                       delete one;
                                   });
    openScenes().insert(owned.get());
    return owned;
}

/// Names of the settings of scenes, or of the properties of objects.
std::vector<std::string> namesOf(bool ofObjects)
{
    std::vector<std::string> names;
    const char* name = nullptr;
    while (midair_setting(ofObjects ? 1 : 0, names.size(), &name, nullptr) == MIDAIR_OK)
        names.emplace_back(name);
    return names;
}

bool isName(bool ofObjects, const py::object& name)
{
    if (!py::isinstance<py::str>(name)) return false;
    const std::vector<std::string> names = namesOf(ofObjects);
    return std::find(names.begin(), names.end(), name.cast<std::string>()) != names.end();
}

/// Text for the value of a setting; True and False become the settings' words.
std::string valueText(const py::object& value)
{
    const bool isBool = py::isinstance<py::bool_>(value) ||
                        py::isinstance(value, py::module_::import("numpy").attr("bool_"));
    if (isBool) return value.cast<bool>() ? "true" : "false";
    return py::str(value);
}

void set(const PyScene& scene, const std::string& name, const py::object& value)
{
    checked(midair_set, scene.get(), name.c_str(), valueText(value).c_str());
}

std::string get(const PyScene& scene, const std::string& name)
{
    return textFrom(midair_get, scene.get(), name.c_str());
}

/// A field passed from another thread; closed if nobody takes it.
struct SolvedField
{
    SolvedField() = default;
    ~SolvedField()
    {
        if (field) midair_field_close(field);
    }
    SolvedField(const SolvedField&) = delete;
    SolvedField& operator=(const SolvedField&) = delete;

    midair_field* field = nullptr;
};

/// Takes the field of a call that Ctrl-C can interrupt.
PyField taken(const std::function<midair_status(midair_field**)>& call,
              const std::function<void()>& cancel)
{
    const auto on = std::make_shared<SolvedField>();
    const Outcome outcome = interruptible([call, on] { return call(&on->field); }, cancel);
    if (outcome.status < 0) raise(outcome.status, outcome.why);
    PyField field = fieldOf(on->field, outcome.status, outcome.why);
    on->field = nullptr;
    return field;
}

PyField solve(const PyScene& scene, bool raiseIfSilent)
{
    midair_scene* const handle = scene.get();
    PyField solved = taken([handle](midair_field** field) { return midair_solve(handle, field); },
                           [handle] { midair_cancel(handle); });
    if (solved.isSilent && raiseIfSilent) raise(MIDAIR_SILENT, solved.why);
    return solved;
}

PyField newest(const PyScene& scene)
{
    midair_field* field = nullptr;
    const midair_status status = checked(midair_newest_field, scene.get(), &field);
    return fieldOf(field, status, midair_last_error());
}

PyField waitField(const PyScene& scene, double timeout)
{
    midair_scene* const handle = scene.get();
    return taken([handle, timeout](midair_field** field)
                 { return midair_wait_field(handle, timeout, field); },
                 [] {});
}

void setEars(const PyScene& scene, const Doubles& positions)
{
    const std::size_t count = positions.size() == 0 ? 0 : rowsOf(positions, "positions");
    checked(midair_set_ears, scene.get(), positions.data(), count);
}

/// Converts triangles to indices; fails if a number would change.
Indices indicesOf(const py::object& given)
{
    const py::array all = py::array::ensure(given);
    if (!all) throw py::type_error("triangles has to be an array of integers");
    if (all.ndim() != 2 || all.shape(1) != 3)
        throw py::value_error("triangles has to have the shape (n, 3), not " + shapeOf(all));
    if (all.dtype().kind() != 'i' && all.dtype().kind() != 'u')
        throw py::type_error("triangles has to have integers, not " +
                             py::str(all.dtype()).cast<std::string>());
    if (all.size() > 0)
        for (const char* end : {"min", "max"})
            integerOf(all.attr(end)(), "an index of triangles", 0, 0xffffffff);
    return Indices::ensure(all);
}

PyObjectOfScene addMesh(const std::shared_ptr<PyScene>& scene,
                        const Doubles& vertices,
                        const py::object& corners,
                        const std::optional<Floats>& intensity)
{
    PyObjectOfScene object{scene, 0};
    const std::size_t v = rowsOf(vertices, "vertices");
    const Indices triangles = indicesOf(corners);
    if (intensity) requireEach(*intensity, "intensity", v, "vertex");
    const auto t = static_cast<std::size_t>(triangles.shape(0));
    const float* const factors = intensity ? intensity->data() : nullptr;
    checked(midair_add_mesh,
            scene->get(),
            vertices.data(),
            v,
            triangles.data(),
            t,
            factors,
            &object.number);
    return object;
}

PyObjectOfScene addFile(const std::shared_ptr<PyScene>& scene, const py::object& file, double size)
{
    PyObjectOfScene object{scene, 0};
    const std::string path = pathOf(file);
    checked(midair_add_file, scene->get(), path.c_str(), size, &object.number);
    return object;
}

PyObjectOfScene addPoints(const std::shared_ptr<PyScene>& scene,
                          const Doubles& positions,
                          const std::optional<Doubles>& pressures,
                          bool inPascal)
{
    PyObjectOfScene object{scene, 0};
    const std::size_t count = rowsOf(positions, "positions");
    if (pressures) requireEach(*pressures, "pressures", count, "point");
    const double* const wanted = pressures ? pressures->data() : nullptr;
    checked(midair_add_points,
            scene->get(),
            positions.data(),
            wanted,
            count,
            inPascal ? 1 : 0,
            &object.number);
    return object;
}

PyObjectOfScene addSensation(const std::shared_ptr<PyScene>& scene, const py::object& sensation)
{
    PyObjectOfScene object{scene, 0};
    const std::string text = pathOf(sensation);
    checked(midair_add_sensation, scene->get(), text.c_str(), &object.number);
    return object;
}

void setPose(const PyObjectOfScene& object, const Doubles& matrix)
{
    if (matrix.ndim() != 2 || matrix.shape(0) != 4 || matrix.shape(1) != 4)
        throw py::value_error("matrix has to have the shape (4, 4), not " + shapeOf(matrix));
    checked(midair_set_pose, object.scene->get(), object.number, matrix.data());
}

void moveVertices(const PyObjectOfScene& object, const Doubles& vertices)
{
    const std::size_t count = rowsOf(vertices, "vertices");
    checked(midair_move_vertices, object.scene->get(), object.number, vertices.data(), count);
}

py::dict stateOf(const PyScene& scene)
{
    midair_device_state now{};
    checked(midair_state, scene.get(), &now);
    py::dict state;
    state["state"] = kStates[now.state];
    state["sent"] = now.sent;
    state["played"] = now.played;
    state["dropped"] = now.dropped;
    state["lost"] = now.lost;
    state["refused"] = now.refused;
    state["waiting"] = now.waiting;
    state["faults"] = now.faults;
    state["reconnects"] = now.reconnects;
    return state;
}

void setHands(const PyScene& scene, const py::object& given)
{
    const Hands hands = recordsOf<midair_hand>(given, "hands", "hand_dtype");
    checked(midair_set_hands, scene.get(), hands.data(), static_cast<std::size_t>(hands.size()));
}

void setHead(const PyScene& scene,
             const std::optional<Doubles>& position,
             const Doubles& orientation,
             double age_s)
{
    if (!position)
    {
        checked(midair_set_head, scene.get(), static_cast<const midair_head*>(nullptr));
        return;
    }
    const midair_head head = headOf(*position, orientation, age_s);
    checked(midair_set_head, scene.get(), &head);
}

/// None: no head is tracked.
py::object lastHead(const PyScene& scene)
{
    midair_head head{};
    const midair_status status = unlocked(midair_last_head, scene.get(), &head);
    if (status == MIDAIR_NOT_YET) return py::none();
    if (status < 0) raise(status);
    return py::make_tuple(py::array_t<double>(3, head.position),
                          py::array_t<double>(4, head.orientation));
}

/// Contacts or touches; their number may grow between two calls.
template<typename T>
py::array all(const PyScene& scene, midair_status (*copy)(midair_scene*, T*, size_t, size_t*))
{
    std::vector<T> found(16);
    for (;;)
    {
        std::size_t count = 0;
        const midair_status status =
            unlocked(copy, scene.get(), found.data(), found.size(), &count);
        if (status < 0 && status != MIDAIR_TOO_SMALL) raise(status);
        found.resize(count);
        if (status == MIDAIR_OK)
            return py::array_t<T>(static_cast<py::ssize_t>(count), found.data());
    }
}

py::array makeHand(const py::object& id, const Doubles& tip, const Doubles& orientation)
{
    requirePose(tip, "tip", orientation);
    py::array_t<midair_hand> hand(1);
    const auto number = static_cast<std::int32_t>(integerOf(id, "id", INT32_MIN, INT32_MAX));
    checked(midair_make_hand, number, tip.data(), orientation.data(), hand.mutable_data());
    return std::move(hand);
}

std::string describeObject(const PyObjectOfScene& object)
{
    return "<midair.Object " + std::to_string(object.number) + " of " +
           (object.scene->get() ? "a scene on \"" + object.scene->array + "\"" : "a closed scene") +
           ">";
}

std::string describeScene(const PyScene& scene)
{
    if (!scene.get()) return "<midair.Scene, closed>";
    midair_device_state now{};
    checked(midair_state, scene.get(), &now);
    return "<midair.Scene on \"" + scene.array + "\", device " + kStates[now.state] + ">";
}

using ObjectClass = Class<PyObjectOfScene>;

void addProperties(ObjectClass& object)
{
    object
        .def(
            "__contains__",
            [](const PyObjectOfScene&, const py::object& name) { return isName(true, name); },
            py::arg("name"),
            "Returns True if there is a property of that name.")
        .def(
            "__iter__",
            [](const PyObjectOfScene&) { return py::iter(py::cast(namesOf(true))); },
            "Returns the names of all properties, one after the other.")
        .def(
            "__len__",
            [](const PyObjectOfScene&) { return namesOf(true).size(); },
            "Returns the number of properties.")
        .def(
            "keys",
            [](const PyObjectOfScene&) { return namesOf(true); },
            "Returns the names of all properties, a list of str; dict(object) has their values.")
        .def("__repr__", &describeObject, "Returns the object's number and its scene.")
        .def(
            "__setitem__",
            [](const PyObjectOfScene& object, const std::string& name, const py::object& value)
            {
                const std::string text = valueText(value);
                checked(midair_object_set,
                        object.scene->get(),
                        object.number,
                        name.c_str(),
                        text.c_str());
            },
            py::arg("name"),
            py::arg("value"),
            "Sets a property: a number, a bool, or a str with its unit.")
        .def(
            "__getitem__",
            [](const PyObjectOfScene& object, const std::string& name) {
                return textFrom(
                    midair_object_get, object.scene->get(), object.number, name.c_str());
            },
            py::arg("name"),
            "Returns the value of a property, a str.");
}

void addPlaces(ObjectClass& object)
{
    object
        .def("set_pose",
             &setPose,
             py::arg("matrix"),
             "Sets where the object is: a rotation and a translation in m, shape (4, 4), for "
             "columns, in the array's frame.")
        .def("move_vertices",
             &moveVertices,
             py::arg("vertices"),
             "Replaces the vertices, or the places of points: as many, (n, 3), in m.")
        .def(
            "play",
            [](const PyObjectOfScene& object)
            { checked(midair_sensation_play, object.scene->get(), object.number, 1); },
            "Begins its sensation anew with the next update(); its trigger is program.")
        .def(
            "stop",
            [](const PyObjectOfScene& object)
            { checked(midair_sensation_play, object.scene->get(), object.number, 0); },
            "Ends its sensation with the next update(); its trigger is program.")
        .def(
            "remove",
            [](const PyObjectOfScene& object)
            { checked(midair_remove, object.scene->get(), object.number); },
            "Takes the object out of its scene.")
        .def_readonly(
            "number", &PyObjectOfScene::number, "An int, as points, contacts and touches name it.");
}

void addObject(py::module_& module)
{
    ObjectClass object(module,
                       "Object",
                       "An object of a scene: object[\"pressure\"] = \"500 Pa\" sets a property by "
                       "its name in scene files, and for name in object names them all.");
    addProperties(object);
    addPlaces(object);
}

void addHands(py::module_& module)
{
    PYBIND11_NUMPY_DTYPE(
        midair_joint, position, orientation, radius_m, position_valid, orientation_valid);
    PYBIND11_NUMPY_DTYPE(midair_hand, id, reserved, age_s, joints);
    PYBIND11_NUMPY_DTYPE(midair_contact,
                         id,
                         object,
                         hand,
                         foci,
                         centre,
                         normal,
                         depth_m,
                         area_m2,
                         semi_major_m,
                         semi_minor_m,
                         speed_m_s,
                         pressure_Pa,
                         share);
    PYBIND11_NUMPY_DTYPE(
        midair_touch, object, hand, finger, touching, reserved, position, distance_m, force_N);
    PYBIND11_NUMPY_DTYPE(midair_sensation,
                         object,
                         playing,
                         stopped,
                         pattern_time_ms,
                         position,
                         intensity,
                         pressure_Pa);
    PYBIND11_NUMPY_DTYPE(midair_ear, position, level_dB, eq_dB, max_dB);
    PYBIND11_NUMPY_DTYPE(midair_coincidence, object, median_m, most_m, state, largest, unknown);
    module.attr("hand_dtype") = py::dtype::of<midair_hand>();
    define(module,
           "hand",
           &makeHand,
           py::arg("id"),
           py::arg("tip"),
           py::arg("orientation") = std::vector<double>{0.0, 0.0, 0.0, 1.0},
           "Returns the open hand of an adult with its index finger's tip at tip, (3,), in m; an "
           "array of hand_dtype, shape (1,). id: 0 left, 1 right; orientation: x, y, z, w, (4,): "
           "turned by it the fingers point along -z and the back of the hand along +y.");
}

void addSettings(SceneClass& scene)
{
    scene
        .def(py::init(&makeScene),
             py::arg("array"),
             "Makes a scene without objects. array: an Array, the name of one, or a JSON file (str "
             "or os.PathLike).")
        .def(
            "__contains__",
            [](const PyScene&, const py::object& name) { return isName(false, name); },
            py::arg("name"),
            "Returns True if there is a setting of that name.")
        .def(
            "__iter__",
            [](const PyScene&) { return py::iter(py::cast(namesOf(false))); },
            "Returns the names of all settings, one after the other.")
        .def(
            "__len__",
            [](const PyScene&) { return namesOf(false).size(); },
            "Returns the number of settings.")
        .def(
            "keys",
            [](const PyScene&) { return namesOf(false); },
            "Returns the names of all settings, a list of str; dict(scene) has their values.")
        .def("__repr__", &describeScene, "Returns the array and what its device does.")
        .def("__setitem__",
             &set,
             py::arg("name"),
             py::arg("value"),
             "Sets a setting: a number, a bool, or a str with its unit.")
        .def("__getitem__", &get, py::arg("name"), "Returns the value of a setting, a str.");
}

void addSolving(SceneClass& scene)
{
    scene
        .def("add_mesh",
             &addMesh,
             py::arg("vertices"),
             py::arg("triangles"),
             py::arg("intensity") = py::none(),
             "Adds a mesh and returns its Object. vertices: (n, 3), m; triangles: integers (t, 3), "
             "indices of vertices, (a, b, b) is a line, (a, a, a) a point; intensity: (n,), 0 .. "
             "1, a factor on the pressure, None: 1.")
        .def("add_file",
             &addFile,
             py::arg("file"),
             py::arg("size") = 0.0,
             "Adds the mesh of a Wavefront OBJ file (str or os.PathLike) and returns its Object. "
             "size: its largest extent in m, and its centre goes to the origin; 0: as in the file.")
        .def("add_points",
             &addPoints,
             py::arg("positions"),
             py::arg("pressures") = py::none(),
             py::arg("pascal") = false,
             "Adds control points, solved without sampling, and returns their Object. positions: "
             "(n, "
             "3), m; pressures: (n,), Pa if pascal, else relative to each other, None: 1.")
        .def("add_sensation",
             &addSensation,
             py::arg("sensation"),
             "Adds a sensation and returns its Object: a classic, \"circle?radius=20mm\", the path "
             "of an .adaptics file, or such a file's text. Its properties say where, when and how "
             "it plays: attach, trigger, parameters, pressure.")
        .def("solve",
             &solve,
             py::arg("raise_if_silent") = false,
             "Solves the scene once, as midair-solve does, and returns the Field. A silent field "
             "has silent and why set, or raises Error with raise_if_silent. A solver of "
             "yours that raises is an Error whose status is \"failed\". Ctrl-C breaks it off.")
        .def(
            "cancel",
            [](const PyScene& s) { checked(midair_cancel, s.get()); },
            "Aborts all running solves of the scene, in other threads: they raise Error, whose "
            "status is \"stopped\".");
}

void addPlaying(SceneClass& scene)
{
    scene
        .def(
            "play",
            [](const PyScene& s, const std::string& device)
            { checked(midair_play, s.get(), device.c_str()); },
            py::arg("device") = "sim:",
            "Plays the scene on that device, a URI, from the next update() on. Returns at once: "
            "state shows the progress of opening it.")
        .def(
            "update",
            [](const PyScene& s, double time) { checked(midair_update, s.get(), time); },
            py::arg("time"),
            "Sends the present scene to the device; to be called with each frame. time: s, which "
            "must not decrease.")
        .def(
            "stop",
            [](const PyScene& s) { checked(midair_stop, s.get()); },
            "Ends playing: silences at once, then closes the device.")
        .def(
            "mute",
            [](const PyScene& s, bool muted) { checked(midair_mute, s.get(), muted ? 1 : 0); },
            py::arg("muted"),
            "True: silences the array at once and keeps it silent; False: plays again.")
        .def("newest_field",
             &newest,
             "Returns the newest Field that was played; Error \"not yet\": none so far.")
        .def("wait_field",
             &waitField,
             py::arg("timeout") = 5.0,
             "Waits, at most timeout s, for the Field of the newest update(), and returns it. "
             "Error \"not yet\": it isn't there by then, or, at once, none comes. Ctrl-C ends the "
             "wait.")
        .def("set_ears",
             &setEars,
             py::arg("positions"),
             "Sets where ears are: (n, 3), m, in the array's frame; n is 0 to 64. The ear limit "
             "holds there as well.")
        .def(
            "set_reflectors",
            [](const PyScene& s, const std::string& json)
            { checked(midair_set_reflectors, s.get(), json.c_str()); },
            py::arg("json"),
            "Sets flat things that reflect sound: '{\"reflectors\": [..]}' as in array files, in "
            "the array's frame, besides those of the array; \"\": none. They may move with each "
            "update.")
        .def_property_readonly(
            "ears",
            [](const PyScene& s) { return all(s, midair_ears); },
            "How loud it is at each ear of set_ears(), then at each of \"earPoints\", a structured "
            "array, shape (n,): position (3,) in m, level_dB now, eq_dB on average, max_dB over a "
            "second; a copy.");
}

void addHead(SceneClass& scene)
{
    scene
        .def(
            "set_head",
            &setHead,
            py::arg("position"),
            py::arg("orientation") = std::vector<double>{0.0, 0.0, 0.0, 1.0},
            py::arg("age") = 0.0,
            "Sets the head for 0.2 s: position (3,) in m, in the array's frame, the midpoint "
            "between the eyes; orientation x, y, z, w, (4,), in whose frame it looks along -z with "
            "+y up; age in s, 0 or more. Its ears are listened at as those of set_ears() are, also "
            "after it was lost. None: there is no head any more.")
        .def(
            "open_head",
            [](const PyScene& s, const std::string& source)
            { checked(midair_open_head, s.get(), source.c_str()); },
            py::arg("source"),
            "Takes the head from a source: \"fixed X Y Z\" in m, \"recorded:FILE\", \"openxr:\", "
            "\"osc:\" or \"NAME:options\" of register_head(); \"none\": from set_head() again.")
        .def(
            "set_display",
            [](const PyScene& s, const std::string& file)
            { checked(midair_set_display, s.get(), file.c_str()); },
            py::arg("file"),
            "Sets the display that shows the scene, a *.display.json in the array's frame; \"\": "
            "none. It is for coincidence; nothing is drawn.")
        .def_property_readonly(
            "coincidence",
            [](const PyScene& s) { return all(s, midair_list_coincidence); },
            "Distances between where the first 16 objects are seen and felt, a structured array, "
            "shape (n,): object, median_m, most_m (95 %) and state, each of (8,): array, display, "
            "eye, ipd, air, motion, tracker, total; state 0 unknown, 1 known, 2 none; largest, "
            "the largest known part; unknown, why the total is; a copy.")
        .def_property_readonly(
            "head",
            &lastHead,
            "The head of the last update(), predicted as hands are: position (3,) in m and "
            "orientation (4,), a tuple of copies; None: no head is tracked.");
}

void addHandsAndState(SceneClass& scene)
{
    scene
        .def("set_hands",
             &setHands,
             py::arg("hands"),
             "Sets the hands for 0.2 s: an array of hand_dtype, shape (n,), in m and in the "
             "array's frame.")
        .def(
            "open_hands",
            [](const PyScene& s, const std::string& source)
            { checked(midair_open_hands, s.get(), source.c_str()); },
            py::arg("source"),
            "Takes the hands from a source: \"recorded:FILE\", \"openxr:\", \"osc:\" or "
            "\"NAME:options\" of register_hands(); \"none\": from set_hands() again.")
        .def_property_readonly(
            "hands",
            [](const PyScene& s) { return all(s, midair_last_hands); },
            "Hands of the last update(), predicted if the scene predicts: a copy, an array of "
            "hand_dtype, shape (n,), in m and in the array's frame.")
        .def_property_readonly(
            "state",
            &stateOf,
            "State of the array, a dict: state is \"closed\", \"opening\", \"silent\", "
            "\"playing\", \"muted\", \"lost\" or \"fault\"; numbers of fields are sent, played, "
            "dropped, lost, refused and waiting; faults and reconnects are the device's.")
        .def_property_readonly(
            "status",
            [](const PyScene& s) { return textFrom(midair_device_status, s.get()); },
            "One line about the device, a str.")
        .def_property_readonly(
            "contacts",
            [](const PyScene& s) { return all(s, midair_contacts); },
            "The contacts of the newest field, a structured array, shape (n,): centre (3,) in m, "
            "depth_m, area_m2, speed_m_s, pressure_Pa and so on; a copy.")
        .def_property_readonly(
            "touches",
            [](const PyScene& s) { return all(s, midair_touches); },
            "Fingers near objects with touchEvents, a structured array, shape (n,): position (3,) "
            "in m, distance_m, force_N and so on; a copy.")
        .def_property_readonly(
            "sensations",
            [](const PyScene& s) { return all(s, midair_sensations); },
            "The sensations of the newest field, a structured array, shape (n,): playing, "
            "position (3,) in m, intensity, pattern_time_ms and so on; a copy.")
        .def("close", &PyScene::close, "Stops playing, silences the device, frees the scene.")
        .def(
            "__enter__", [](const std::shared_ptr<PyScene>& s) { return s; }, "Returns the scene.")
        .def(
            "__exit__",
            [](PyScene& s, const py::object&, const py::object&, const py::object&) { s.close(); },
            py::arg("type"),
            py::arg("value"),
            py::arg("traceback"),
            "Closes the scene.");
}

} // namespace

void requirePose(const Doubles& place, const char* name, const Doubles& orientation)
{
    if (place.ndim() != 1 || place.size() != 3)
        throw py::value_error(std::string(name) + " has to have the shape (3,), not " +
                              shapeOf(place));
    if (orientation.ndim() != 1 || orientation.size() != 4)
        throw py::value_error("orientation has to have the shape (4,), x, y, z, w, not " +
                              shapeOf(orientation));
}

midair_head headOf(const Doubles& position, const Doubles& orientation, double age_s)
{
    requirePose(position, "position", orientation);
    midair_head head{};
    std::copy_n(position.data(), 3, head.position);
    std::copy_n(orientation.data(), 4, head.orientation);
    head.age_s = age_s;
    return head;
}

void closeScenes()
{
    const std::set<PyScene*> open = openScenes();
    for (PyScene* scene : open)
        scene->close();
}

void addScenes(py::module_& module)
{
    addHands(module);
    addObject(module);
    SceneClass scene(
        module,
        "Scene",
        "Scene(array)\n--\n\nObjects, settings, hands, and the device that plays them. "
        "scene[\"maxPressure\"] = \"800 Pa\" sets a setting by its name in scene files, and for "
        "name in scene names them all. Places are in the array's frame: the origin of \"octagon\" "
        "is the centre of its workspace, that of \"board\" the middle of its own plane, so that "
        "(0, 0, 0.15) is over it. A scene closes at the end of a with statement.");
    addSettings(scene);
    addSolving(scene);
    addPlaying(scene);
    addHead(scene);
    addHandsAndState(scene);
    addMessages(module, scene);
    addMany(scene);
}

} // namespace midair::python
