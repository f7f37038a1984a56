// Wrong arguments are errors with a text, for every function: null, NaN, wrong sizes, closed
// handles.
#include "engine-bridge/c/inside/Field.h"
#include "engine-bridge/player/SceneSolve.h"
#include "haptics/array/TransducerArray.h"
#include "tests/engine-bridge/c/Opened.h"

#include <cmath>
#include <limits>

namespace
{

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

#define EXPECT_STATUS(call, wanted)                                                                \
    do                                                                                             \
    {                                                                                              \
        EXPECT_EQ(call, wanted) << midair_last_error();                                            \
        EXPECT_STRNE(midair_last_error(), "") << #call;                                            \
    } while (false)

} // namespace

TEST(CArguments, ClosedAndNullHandlesAreToldByEachFunction)
{
    midair_array* array = nullptr;
    midair_scene* scene = nullptr;
    midair_solver* solver = nullptr;
    ASSERT_EQ(midair_array_load("board", &array), MIDAIR_OK);
    ASSERT_EQ(midair_scene_make(array, &scene), MIDAIR_OK);
    ASSERT_EQ(midair_solver_open(scene, &solver), MIDAIR_OK);
    ASSERT_EQ(midair_solver_close(solver), MIDAIR_OK);
    ASSERT_EQ(midair_scene_close(scene), MIDAIR_OK);
    ASSERT_EQ(midair_array_close(array), MIDAIR_OK);
    // A pointer to something else is none of a handle either.
    midair_scene* const foreign = reinterpret_cast<midair_scene*>(&scene);
    for (midair_scene* gone : {scene, static_cast<midair_scene*>(nullptr), foreign})
    {
        midair_object object = 0;
        midair_field* field = nullptr;
        midair_device_state state{};
        midair_hand hand{};
        std::size_t count = 0;
        const double numbers[16] = {};
        const uint32_t triangle[] = {0, 0, 0};
        EXPECT_STATUS(midair_scene_close(gone), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_set(gone, "cycle", "2"), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_get(gone, "cycle", nullptr, 0, &count), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_add_mesh(gone, numbers, 1, triangle, 1, nullptr, &object),
                      MIDAIR_CLOSED);
        EXPECT_STATUS(midair_add_file(gone, "star.obj", 0.0, &object), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_add_points(gone, numbers, nullptr, 1, 0, &object), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_move_vertices(gone, 1, numbers, 1), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_set_pose(gone, 1, numbers), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_object_set(gone, 1, "side", "front"), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_object_get(gone, 1, "side", nullptr, 0, &count), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_remove(gone, 1), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_solve(gone, &field), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_cancel(gone), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_solver_open(gone, &solver), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_play(gone, "sim:"), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_update(gone, 0.0), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_stop(gone), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_mute(gone, 1), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_state(gone, &state), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_device_status(gone, nullptr, 0, &count), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_messages(gone, nullptr, 0, &count), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_newest_field(gone, &field), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_set_hands(gone, &hand, 1), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_open_hands(gone, "none"), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_last_hands(gone, nullptr, 0, &count), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_contacts(gone, nullptr, 0, &count), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_touches(gone, nullptr, 0, &count), MIDAIR_CLOSED);
        EXPECT_EQ(field, nullptr);
    }
    std::size_t size = 0;
    midair_transducer one{};
    EXPECT_STATUS(midair_array_size(array, &size), MIDAIR_CLOSED);
    EXPECT_STATUS(midair_array_transducers(array, &one, 1), MIDAIR_CLOSED);
    EXPECT_STATUS(midair_array_close(array), MIDAIR_CLOSED);
    EXPECT_STATUS(midair_scene_make(array, &scene), MIDAIR_CLOSED);
    float q[2] = {};
    double value = 0.0;
    const double place[3] = {};
    EXPECT_STATUS(midair_solver_solve(solver, place, place, 1, 0, q, 1), MIDAIR_CLOSED);
    EXPECT_STATUS(midair_solver_figure(solver, "rms", &value), MIDAIR_CLOSED);
    EXPECT_STATUS(midair_solver_close(solver), MIDAIR_CLOSED);
}

TEST(CArguments, ClosedFieldsAreToldByEachFunction)
{
    Opened of("board");
    const double place[] = {0.0, 0.0, 0.15};
    midair_object points = 0;
    ASSERT_EQ(midair_add_points(of.scene, place, nullptr, 1, 0, &points), MIDAIR_OK);
    midair_field* closed = nullptr;
    ASSERT_EQ(midair_solve(of.scene, &closed), MIDAIR_OK);
    ASSERT_EQ(midair_field_close(closed), MIDAIR_OK);
    // A handle of another kind is one of nothing, too.
    auto* const other = reinterpret_cast<midair_field*>(of.scene);
    for (midair_field* gone : {closed, static_cast<midair_field*>(nullptr), other})
    {
        midair_field_info info{};
        midair_point point{};
        float numbers[2] = {};
        int32_t level = 0;
        const float* view = nullptr;
        const char* name = nullptr;
        double value = 0.0;
        EXPECT_STATUS(midair_field_about(gone, &info), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_field_activations(gone, 0, numbers, 1), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_field_view(gone, 0, &view), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_field_levels(gone, 0, &level, &level, 1), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_field_write_drive(gone, 0, "/dev/null"), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_field_points(gone, &point, 1), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_field_figure(gone, "rms", &value), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_field_figure_at(gone, 0, &name, &value), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_field_text(gone, "stop", nullptr, 0, nullptr), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_field_pressures(gone, 0, place, 1, numbers), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_field_felt(gone, place, 1, numbers), MIDAIR_CLOSED);
        EXPECT_STATUS(midair_field_close(gone), MIDAIR_CLOSED);
    }
}

TEST(CArguments, NullIsToldByItsName)
{
    Opened of("board");
    const double place[] = {0.0, 0.0, 0.15};
    midair_object points = 0;
    ASSERT_EQ(midair_add_points(of.scene, place, nullptr, 1, 0, &points), MIDAIR_OK);
    const Solved solved(of.scene);
    midair_array* array = nullptr;
    midair_transducer one{};
    EXPECT_STATUS(midair_array_load(nullptr, &array), MIDAIR_INVALID);
    EXPECT_STREQ(midair_last_error(), "name_or_file is NULL");
    EXPECT_STATUS(midair_array_load("board", nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_array_from_json(nullptr, &array), MIDAIR_INVALID);
    EXPECT_STATUS(midair_array_make(nullptr, &one, 1, 40e3, 1.0, &array), MIDAIR_INVALID);
    EXPECT_STATUS(midair_array_make("one", nullptr, 1, 40e3, 1.0, &array), MIDAIR_INVALID);
    EXPECT_STATUS(midair_array_size(of.array, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_array_transducers(of.array, nullptr, 1000), MIDAIR_INVALID);
    EXPECT_STATUS(midair_scene_make(of.array, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_set(of.scene, nullptr, "1"), MIDAIR_INVALID);
    EXPECT_STATUS(midair_set(of.scene, "cycle", nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_get(of.scene, "cycle", nullptr, 10, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_add_mesh(of.scene, nullptr, 1, nullptr, 1, nullptr, &points),
                  MIDAIR_INVALID);
    EXPECT_STATUS(midair_add_file(of.scene, nullptr, 0.0, &points), MIDAIR_INVALID);
    EXPECT_STATUS(midair_add_points(of.scene, nullptr, nullptr, 1, 0, &points), MIDAIR_INVALID);
    EXPECT_STATUS(midair_add_points(of.scene, place, nullptr, 1, 0, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_set_pose(of.scene, points, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_move_vertices(of.scene, points, nullptr, 1), MIDAIR_INVALID);
    EXPECT_STATUS(midair_solve(of.scene, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_field_about(solved.field, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_field_activations(solved.field, 0, nullptr, 249), MIDAIR_INVALID);
    EXPECT_STATUS(midair_field_points(solved.field, nullptr, 1), MIDAIR_INVALID);
    EXPECT_STATUS(midair_field_figure(solved.field, nullptr, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_field_pressures(solved.field, 0, nullptr, 1, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_field_felt(solved.field, place, 1, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_play(of.scene, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_state(of.scene, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_set_hands(of.scene, nullptr, 1), MIDAIR_INVALID);
    EXPECT_STATUS(midair_open_hands(of.scene, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_make_hand(0, nullptr, place, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_last_hands(of.scene, nullptr, 0, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_contacts(of.scene, nullptr, 0, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_register_device("one", nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_register_solver("one", nullptr, nullptr), MIDAIR_INVALID);
    EXPECT_STATUS(midair_register_hands("one", nullptr), MIDAIR_INVALID);
    EXPECT_EQ(midair_set(of.scene, "cycle", "1"), MIDAIR_OK);
    EXPECT_STREQ(midair_last_error(), "") << "a call that succeeds leaves no error";
}

TEST(CArguments, NumbersThatAreNoneOrOutOfRangeAreRefused)
{
    Opened of("board");
    midair_object object = 0;
    const double vertices[] = {0, 0, 0.15, 0.01, 0, 0.15, 0, kNan, 0.15};
    const double sound[] = {0, 0, 0.15, 0.01, 0, 0.15, 0, 0.01, 0.15};
    const uint32_t triangle[] = {0, 1, 2};
    const uint32_t beyond[] = {0, 1, 3};
    const float intensity[] = {0.5F, 1.5F, 0.0F};
    EXPECT_STATUS(midair_add_mesh(of.scene, vertices, 3, triangle, 1, nullptr, &object),
                  MIDAIR_INVALID);
    EXPECT_STATUS(midair_add_mesh(of.scene, sound, 3, beyond, 1, nullptr, &object), MIDAIR_INVALID);
    EXPECT_STREQ(midair_last_error(), "triangle 0 has the vertex 3; there are 3, from 0");
    EXPECT_STATUS(midair_add_mesh(of.scene, sound, 3, triangle, 1, intensity, &object),
                  MIDAIR_INVALID);
    EXPECT_STATUS(midair_add_mesh(of.scene, sound, 0, triangle, 1, nullptr, &object),
                  MIDAIR_INVALID);
    EXPECT_STATUS(midair_add_mesh(of.scene, sound, SIZE_MAX, triangle, 1, nullptr, &object),
                  MIDAIR_INVALID);
    EXPECT_STATUS(midair_add_file(of.scene, "star.obj", kNan, &object), MIDAIR_INVALID);
    EXPECT_STATUS(midair_add_file(of.scene, "/nosuch.obj", 0.0, &object), MIDAIR_REFUSED);
    const double pressures[] = {100.0, -1.0, 2.0};
    EXPECT_STATUS(midair_add_points(of.scene, sound, pressures, 3, 1, &object), MIDAIR_INVALID);
    EXPECT_STATUS(midair_add_points(of.scene, vertices, nullptr, 3, 0, &object), MIDAIR_INVALID);
    EXPECT_STATUS(midair_add_points(of.scene, sound, nullptr, 3, 1, &object), MIDAIR_INVALID);
    EXPECT_EQ(object, 0U) << "nothing is written with an error";
    ASSERT_EQ(midair_add_mesh(of.scene, sound, 3, triangle, 1, nullptr, &object), MIDAIR_OK);
    double pose[16];
    std::copy_n(kIdentity, 16, pose);
    pose[0] = 2.0;
    EXPECT_STATUS(midair_set_pose(of.scene, object, pose), MIDAIR_INVALID);
    pose[0] = -1.0; // a mirror
    EXPECT_STATUS(midair_set_pose(of.scene, object, pose), MIDAIR_INVALID);
    pose[0] = kNan;
    EXPECT_STATUS(midair_set_pose(of.scene, object, pose), MIDAIR_INVALID);
    std::copy_n(kIdentity, 16, pose);
    pose[12] = 0.1; // column by column
    EXPECT_STATUS(midair_set_pose(of.scene, object, pose), MIDAIR_INVALID);
    EXPECT_STATUS(midair_move_vertices(of.scene, object, sound, 2), MIDAIR_INVALID);
    EXPECT_STATUS(midair_object_set(of.scene, object + 1, "side", "front"), MIDAIR_UNKNOWN);
    EXPECT_STATUS(midair_remove(of.scene, object + 1), MIDAIR_UNKNOWN);
    EXPECT_EQ(midair_remove(of.scene, object), MIDAIR_OK);
    EXPECT_STATUS(midair_set_pose(of.scene, object, kIdentity), MIDAIR_UNKNOWN);
    EXPECT_STATUS(midair_update(of.scene, 0.0), MIDAIR_NOT_YET);
    EXPECT_STATUS(midair_update(of.scene, kNan), MIDAIR_INVALID);
    EXPECT_STATUS(midair_mute(of.scene, 2), MIDAIR_INVALID);
    EXPECT_STATUS(midair_play(of.scene, "no uri"), MIDAIR_REFUSED);
    EXPECT_STATUS(midair_open_hands(of.scene, "nosuch:"), MIDAIR_UNKNOWN);
    EXPECT_STATUS(midair_open_hands(of.scene, "recorded:/nosuch.csv"), MIDAIR_REFUSED);
}

TEST(CArguments, TransducersThatCannotBeAreRefused)
{
    midair_transducer two[2] = {};
    two[0].normal[2] = two[1].normal[2] = 1.0;
    two[1].position[0] = 0.01;
    two[0].gain = two[1].gain = 1.0;
    midair_array* array = nullptr;
    ASSERT_EQ(midair_array_make("two", two, 2, 40e3, 1.0, &array), MIDAIR_OK)
        << midair_last_error();
    EXPECT_EQ(midair_array_close(array), MIDAIR_OK);
    const auto refused = [&](auto change)
    {
        midair_transducer changed[2] = {two[0], two[1]};
        change(changed[1]);
        midair_array* made = nullptr;
        EXPECT_STATUS(midair_array_make("two", changed, 2, 40e3, 1.0, &made), MIDAIR_INVALID);
        EXPECT_EQ(made, nullptr);
    };
    refused([](midair_transducer& one) { one.position[1] = kNan; });
    refused([](midair_transducer& one) { one.position[1] = 11.0; });
    refused([](midair_transducer& one) { one.normal[2] = 0.0; });
    refused([](midair_transducer& one) { one.gain = -1.0; });
    refused([](midair_transducer& one) { one.phase_offset_rad = kNan; });
    refused([](midair_transducer& one) { one.board = 2; });
    refused([](midair_transducer& one) { one.dead = 7; });
    EXPECT_STATUS(midair_array_make("two", two, 0, 40e3, 1.0, &array), MIDAIR_INVALID);
    EXPECT_STATUS(midair_array_make("two", two, 2, kNan, 1.0, &array), MIDAIR_INVALID);
    EXPECT_STATUS(midair_array_make("two", two, 2, 40e3, kNan, &array), MIDAIR_INVALID);
    EXPECT_STATUS(midair_array_from_json("{", &array), MIDAIR_REFUSED);
    EXPECT_STATUS(midair_array_load("nosuch", &array), MIDAIR_REFUSED);
}

TEST(CArguments, ASafetyValueThatIsNotUnderstoodSilencesUntilItIs)
{
    Opened of("board");
    const double place[] = {0.0, 0.0, 0.15};
    midair_object points = 0;
    ASSERT_EQ(midair_add_points(of.scene, place, nullptr, 1, 0, &points), MIDAIR_OK);
    EXPECT_STATUS(midair_set(of.scene, "maxPresure", "300"), MIDAIR_UNKNOWN);
    EXPECT_STREQ(midair_last_error(),
                 "unknown option \"maxPresure\" (did you mean maxPressure?); nothing is played");
    EXPECT_EQ(Solved(of.scene).status, MIDAIR_SILENCED);
    EXPECT_EQ(midair_set(of.scene, "maxPressure", "3 kPa"), MIDAIR_OK);
    EXPECT_EQ(Solved(of.scene).status, MIDAIR_OK);
    EXPECT_STATUS(midair_set(of.scene, "maxAmplitude", "2"), MIDAIR_INVALID);
    EXPECT_EQ(Solved(of.scene).status, MIDAIR_SILENCED);
    EXPECT_EQ(midair_set(of.scene, "maxAmplitude", "1"), MIDAIR_OK);
    EXPECT_STATUS(midair_set(of.scene, "cycle", "many"), MIDAIR_INVALID);
    EXPECT_EQ(Solved(of.scene).status, MIDAIR_OK) << "a cycle is no matter of safety";
    EXPECT_STATUS(midair_object_set(of.scene, points, "enabled", "perhaps"), MIDAIR_INVALID);
    EXPECT_EQ(Solved(of.scene).status, MIDAIR_SILENCED);
    EXPECT_EQ(midair_object_set(of.scene, points, "enabled", "true"), MIDAIR_OK);
    EXPECT_EQ(Solved(of.scene).status, MIDAIR_OK);
    EXPECT_STATUS(midair_object_set(of.scene, points, "pressure", "5"), MIDAIR_INVALID);
    EXPECT_STATUS(midair_object_set(of.scene, points, "material", "glas"), MIDAIR_UNKNOWN);
    EXPECT_EQ(midair_set(of.scene, "enabled", "false"), MIDAIR_OK);
    EXPECT_EQ(Solved(of.scene).status, MIDAIR_SILENCED);
}

TEST(CArguments, TextsAreCutByNobody)
{
    Opened of("board");
    std::size_t needed = 0;
    ASSERT_EQ(midair_set(of.scene, "earPoints", "0 0 0.6; 30 0 60 cm"), MIDAIR_OK)
        << midair_last_error();
    ASSERT_EQ(midair_get(of.scene, "earPoints", nullptr, 0, &needed), MIDAIR_OK);
    EXPECT_EQ(needed, std::string("0 0 0.6; 30 0 60 cm").size() + 1);
    std::vector<char> text(needed);
    EXPECT_STATUS(midair_get(of.scene, "earPoints", text.data(), needed - 1, nullptr),
                  MIDAIR_TOO_SMALL);
    EXPECT_EQ(midair_get(of.scene, "earPoints", text.data(), needed, nullptr), MIDAIR_OK);
    EXPECT_STREQ(text.data(), "0 0 0.6; 30 0 60 cm");
    EXPECT_STATUS(midair_set(of.scene, "earPoints", "0 0"), MIDAIR_INVALID);
    EXPECT_STATUS(midair_get(of.scene, "nosuch", text.data(), needed, nullptr), MIDAIR_UNKNOWN);
    const std::string endless(1 << 20, 'x');
    EXPECT_STATUS(midair_set(of.scene, endless.c_str(), "1"), MIDAIR_INVALID);
    EXPECT_STREQ(midair_status_name(MIDAIR_TOO_SMALL), "too small");
    EXPECT_STREQ(midair_status_name(77), "unknown status");
    EXPECT_EQ(midair_version(), uint32_t(MIDAIR_VERSION));
}

// The numbers are part of the interface of programs that were built before.
TEST(CArguments, StatusesKeepTheirNumbers)
{
    const midair_status all[] = {MIDAIR_OK,
                                 MIDAIR_SILENT,
                                 MIDAIR_INVALID,
                                 MIDAIR_CLOSED,
                                 MIDAIR_UNKNOWN,
                                 MIDAIR_REFUSED,
                                 MIDAIR_TOO_SMALL,
                                 MIDAIR_NOT_YET,
                                 MIDAIR_STOPPED,
                                 MIDAIR_SILENCED,
                                 MIDAIR_NO_MEMORY,
                                 MIDAIR_FAILED};
    const midair_status wanted[] = {0, 1, -1, -2, -3, -4, -5, -6, -7, -8, -9, -10};
    for (std::size_t i = 0; i < std::size(wanted); ++i)
        EXPECT_EQ(all[i], wanted[i]);
}

// What hears an array that doesn't sound is nowhere around it.
TEST(CField, PlacesHeardAreThoseOfTheEarsAloneWhereNothingSounds)
{
    midair::haptics::TransducerArray array = midair::haptics::TransducerArray::load("board");
    const Eigen::Matrix3Xd ears = Eigen::Vector3d(0.1, 0.2, 0.5);
    EXPECT_EQ(midair::bridge::placesHeard(array, ears).cols(), 33);
    array.gain.setZero(array.size());
    EXPECT_EQ(midair::bridge::placesHeard(array, ears), ears);
}
