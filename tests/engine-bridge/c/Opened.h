#pragma once

#include <cstdlib>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <midair.h>

/// A scene of the C interface on an array, closed when it goes.
class Opened
{
public:
    explicit Opened(const char* name = "octagon") : Opened(name, midair_array_load) {}
    ~Opened()
    {
        midair_scene_close(scene);
        midair_array_close(array);
    }
    Opened(const Opened&) = delete;
    Opened& operator=(const Opened&) = delete;

    std::string messages() const
    {
        std::vector<char> text(65536);
        EXPECT_EQ(midair_messages(scene, text.data(), text.size(), nullptr), MIDAIR_OK);
        return text.data();
    }

    midair_array* array = nullptr;
    midair_scene* scene = nullptr;

protected:
    /// \a open: midair_array_load() or midair_array_from_json().
    Opened(const char* given, midair_status (*open)(const char*, midair_array**))
    {
        EXPECT_EQ(open(given, &array), MIDAIR_OK) << midair_last_error();
        EXPECT_EQ(midair_scene_make(array, &scene), MIDAIR_OK) << midair_last_error();
    }
};

/// A field of the C interface, closed when it goes.
class Solved
{
public:
    explicit Solved(midair_scene* scene) : status(midair_solve(scene, &field))
    {
        why = midair_last_error();
        if (field) midair_field_about(field, &info);
    }
    ~Solved()
    {
        if (field) midair_field_close(field);
    }
    Solved(const Solved&) = delete;
    Solved& operator=(const Solved&) = delete;

    double figure(const char* name) const
    {
        double value = 0.0;
        EXPECT_EQ(midair_field_figure(field, name, &value), MIDAIR_OK) << midair_last_error();
        return value;
    }
    std::vector<float> activations(std::size_t index = 0) const
    {
        std::vector<float> q(2 * std::size_t(info.transducers));
        EXPECT_EQ(midair_field_activations(field, index, q.data(), info.transducers), MIDAIR_OK);
        return q;
    }

    midair_field* field = nullptr;
    midair_status status;
    std::string why;
    midair_field_info info{};
};

constexpr double kIdentity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
