// midair.Scene and midair.Object.
#include "engine-bridge/python/Bindings.h"

#include <optional>
#include <set>
#include <vector>

#include <pybind11/stl.h>

namespace midair::python
{

namespace
{

using Indices = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// The scenes that are open; guarded by Python's lock.
std::set<OwnedScene*>& openScenes()
{
    static auto* const all = new std::set<OwnedScene*>;
    return *all;
}

/// midair.Object: keeps its scene.
struct PyObjectOfScene
{
    std::shared_ptr<OwnedScene> scene;
    midair_object number = 0;
};

std::shared_ptr<OwnedScene> makeScene(const OwnedArray& array)
{
    midair_scene* scene = nullptr;
    checked(midair_scene_make, array.get(), &scene);
    const std::shared_ptr<OwnedScene> owned(new OwnedScene(scene),
                                            [](OwnedScene* one)
                                            {
                                                openScenes().erase(one);
                                                delete one;
                                            });
    openScenes().insert(owned.get());
    return owned;
}

std::shared_ptr<OwnedScene> sceneOn(const std::string& name)
{
    midair_array* array = nullptr;
    checked(midair_array_load, name.c_str(), &array);
    return makeScene(OwnedArray(array));
}

/// What a setting is set to: True and False are words of the settings.
std::string valueText(const py::object& value)
{
    if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
    return py::str(value);
}

void set(const OwnedScene& scene, const std::string& name, const py::object& value)
{
    checked(midair_set, scene.get(), name.c_str(), valueText(value).c_str());
}

std::string get(const OwnedScene& scene, const std::string& name)
{
    return textFrom(midair_get, scene.get(), name.c_str());
}

PyField solve(const OwnedScene& scene)
{
    midair_field* field = nullptr;
    PyField solved;
    solved.isSilent = checked(midair_solve, scene.get(), &field) == MIDAIR_SILENT;
    if (solved.isSilent) solved.why = midair_last_error();
    solved.owned = std::make_shared<OwnedField>(field);
    return solved;
}

PyField newest(const OwnedScene& scene)
{
    midair_field* field = nullptr;
    checked(midair_newest_field, scene.get(), &field);
    return {std::make_shared<OwnedField>(field), false, {}};
}

PyField waitField(const OwnedScene& scene, double timeout)
{
    midair_field* field = nullptr;
    checked(midair_wait_field, scene.get(), timeout, &field);
    return {std::make_shared<OwnedField>(field), false, {}};
}

void setEars(const OwnedScene& scene, const Doubles& positions)
{
    const std::size_t count = positions.size() == 0 ? 0 : rowsOf(positions, "positions");
    checked(midair_set_ears, scene.get(), positions.data(), count);
}

PyObjectOfScene addMesh(const std::shared_ptr<OwnedScene>& scene,
                        const Doubles& vertices,
                        const Indices& triangles,
                        const std::optional<Floats>& intensity)
{
    PyObjectOfScene object{scene, 0};
    const std::size_t v = rowsOf(vertices, "vertices");
    if (triangles.ndim() != 2 || triangles.shape(1) != 3)
        throw py::value_error("triangles has to have the shape (n, 3)");
    if (intensity && static_cast<std::size_t>(intensity->size()) != v)
        throw py::value_error("intensity has to have one number for each vertex");
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

PyObjectOfScene
addFile(const std::shared_ptr<OwnedScene>& scene, const std::string& file, double size)
{
    PyObjectOfScene object{scene, 0};
    checked(midair_add_file, scene->get(), file.c_str(), size, &object.number);
    return object;
}

PyObjectOfScene addPoints(const std::shared_ptr<OwnedScene>& scene,
                          const Doubles& positions,
                          const std::optional<Doubles>& pressures,
                          bool inPascal)
{
    PyObjectOfScene object{scene, 0};
    const std::size_t count = rowsOf(positions, "positions");
    if (pressures && static_cast<std::size_t>(pressures->size()) != count)
        throw py::value_error("pressures has to have one number for each point");
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

void setPose(const PyObjectOfScene& object, const Doubles& matrix)
{
    if (matrix.ndim() != 2 || matrix.shape(0) != 4 || matrix.shape(1) != 4)
        throw py::value_error("matrix has to have the shape (4, 4)");
    checked(midair_set_pose, object.scene->get(), object.number, matrix.data());
}

void moveVertices(const PyObjectOfScene& object, const Doubles& vertices)
{
    const std::size_t count = rowsOf(vertices, "vertices");
    checked(midair_move_vertices, object.scene->get(), object.number, vertices.data(), count);
}

py::dict stateOf(const OwnedScene& scene)
{
    midair_device_state now{};
    checked(midair_state, scene.get(), &now);
    constexpr const char* kNames[] = {
        "closed", "opening", "silent", "playing", "muted", "lost", "fault"};
    py::dict state;
    state["state"] = kNames[now.state];
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

void setHands(const OwnedScene& scene, const py::array_t<midair_hand, py::array::c_style>& hands)
{
    checked(midair_set_hands, scene.get(), hands.data(), static_cast<std::size_t>(hands.size()));
}

/// Contacts or touches, of which there may be more at each look.
template<typename T>
py::array all(const OwnedScene& scene, midair_status (*copy)(midair_scene*, T*, size_t, size_t*))
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

py::array makeHand(int id, const Doubles& tip, const Doubles& orientation)
{
    if (tip.size() != 3 || orientation.size() != 4)
        throw py::value_error("tip has three numbers, orientation four: x, y, z, w");
    py::array_t<midair_hand> hand(1);
    checked(midair_make_hand, id, tip.data(), orientation.data(), hand.mutable_data());
    return std::move(hand);
}

void addObject(py::module_& module)
{
    py::class_<PyObjectOfScene>(module, "Object", "An object of a scene.")
        .def("__setitem__",
             [](const PyObjectOfScene& object, const std::string& name, const py::object& value)
             {
                 const std::string text = valueText(value);
                 checked(midair_object_set,
                         object.scene->get(),
                         object.number,
                         name.c_str(),
                         text.c_str());
             })
        .def("__getitem__",
             [](const PyObjectOfScene& object, const std::string& name) {
                 return textFrom(
                     midair_object_get, object.scene->get(), object.number, name.c_str());
             })
        .def("set_pose", &setPose, py::arg("matrix"), "A rotation and a translation, (4, 4).")
        .def("move_vertices",
             &moveVertices,
             py::arg("vertices"),
             "Replaces the vertices, or the places of points: as many, (n, 3).")
        .def("remove",
             [](const PyObjectOfScene& object)
             { checked(midair_remove, object.scene->get(), object.number); })
        .def_readonly(
            "number", &PyObjectOfScene::number, "As points, contacts and touches name it.");
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
    PYBIND11_NUMPY_DTYPE(midair_ear, position, level_dB, eq_dB, max_dB);
    module.attr("hand_dtype") = py::dtype::of<midair_hand>();
    module.def(
        "hand",
        &makeHand,
        py::arg("id"),
        py::arg("tip"),
        py::arg("orientation") = std::vector<double>{0.0, 0.0, 0.0, 1.0},
        "The open hand of an adult with its index finger's tip at tip; hand_dtype, shape (1,).");
}

} // namespace

void closeScenes()
{
    const std::set<OwnedScene*> open = openScenes();
    for (OwnedScene* scene : open)
        scene->close();
}

void addScenes(py::module_& module)
{
    addHands(module);
    addObject(module);
    py::class_<OwnedScene, std::shared_ptr<OwnedScene>> scene(
        module, "Scene", "Objects, settings, hands, and the device that plays them.");
    addMessages(module, scene);
    scene.def(py::init(&makeScene), py::arg("array"))
        .def(py::init(&sceneOn), py::arg("array"), "The name or file of an array does, too.")
        .def("__setitem__", &set, "scene[\"maxPressure\"] = \"800 Pa\": names as in scene files.")
        .def("__getitem__", &get)
        .def("add_mesh",
             &addMesh,
             py::arg("vertices"),
             py::arg("triangles"),
             py::arg("intensity") = py::none())
        .def("add_file", &addFile, py::arg("file"), py::arg("size") = 0.0, "A Wavefront OBJ file.")
        .def("add_points",
             &addPoints,
             py::arg("positions"),
             py::arg("pressures") = py::none(),
             py::arg("pascal") = false)
        .def("solve", &solve, "Solves the scene once, as midair-solve does.")
        .def("cancel", [](const OwnedScene& s) { checked(midair_cancel, s.get()); })
        .def(
            "play",
            [](const OwnedScene& s, const std::string& device)
            { checked(midair_play, s.get(), device.c_str()); },
            py::arg("device") = "sim:",
            "Plays the scene on that device, from the next update() on.")
        .def(
            "update",
            [](const OwnedScene& s, double time) { checked(midair_update, s.get(), time); },
            py::arg("time"),
            "Takes the scene as it is to the device; to be called with each frame.")
        .def("stop", [](const OwnedScene& s) { checked(midair_stop, s.get()); })
        .def(
            "mute",
            [](const OwnedScene& s, bool muted) { checked(midair_mute, s.get(), muted ? 1 : 0); },
            py::arg("muted"))
        .def("newest_field", &newest, "The newest field that was played.")
        .def(
            "wait_field",
            &waitField,
            py::arg("timeout") = 5.0,
            "Waits, at most timeout seconds, for the field of the newest update(), and returns it. "
            "Raises midair.Error with status \"not yet\" if it isn't there by then, and at once if "
            "none comes.")
        .def(
            "set_ears",
            &setEars,
            py::arg("positions"),
            "Sets where ears are: (n, 3) in metres, the array's frame; n is 0 to 64. The ear limit "
            "holds there as well.")
        .def_property_readonly(
            "ears",
            [](const OwnedScene& s) { return all(s, midair_ears); },
            "How loud it is at each ear of set_ears(), then at each of \"earPoints\": (n,) with "
            "the "
            "fields position in m, level_dB now, eq_dB on average, max_dB over a second.")
        .def("set_hands", &setHands, py::arg("hands"), "An array of hand_dtype; for 0.2 s.")
        .def(
            "open_hands",
            [](const OwnedScene& s, const std::string& source)
            { checked(midair_open_hands, s.get(), source.c_str()); },
            py::arg("source"))
        .def_property_readonly("state", &stateOf)
        .def_property_readonly(
            "status", [](const OwnedScene& s) { return textFrom(midair_device_status, s.get()); })
        .def_property_readonly("contacts",
                               [](const OwnedScene& s) { return all(s, midair_contacts); })
        .def_property_readonly("touches",
                               [](const OwnedScene& s) { return all(s, midair_touches); })
        .def("close", &OwnedScene::close)
        .def("__enter__", [](const std::shared_ptr<OwnedScene>& s) { return s; })
        .def("__exit__",
             [](OwnedScene& s, const py::object&, const py::object&, const py::object&)
             { s.close(); });
}

} // namespace midair::python
