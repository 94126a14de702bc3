// Made from the headers by `cargo run -p covbeam-tests --bin header`; do not edit.
changes("light_field_travel", [](Field& f, In& in) { const auto a0 = in.f(); f.travel(a0); },
        [](Rows& r) { many::travel(r.fields(), r.f(16)); });
changes("light_field_rotate", [](Field& f, In& in) { const auto a0 = in.take<std::array<float, 3>>(); f.rotate(a0.data()); },
        [](Rows& r) { many::rotate(r.fields(), r.v(16)); });
changes("light_field_reflect", [](Field& f, In& in) { const auto a0 = in.take<std::array<float, 3>>(); const auto a1 = in.take<covbeam_curvature>(); f.reflect(a0.data(), &a1); },
        [](Rows& r) { many::reflect(r.fields(), r.v(16), r.get<covbeam_curvature>(19)); });
changes("light_field_occlude", [](Field& f, In& in) { const auto a0 = in.take<std::array<float, 3>>(); const auto a1 = in.f(); f.occlude(a0.data(), a1); },
        [](Rows& r) { many::occlude(r.fields(), r.v(16), r.f(19)); });
changes("light_field_attenuate", [](Field& f, In& in) { const auto a0 = in.take<std::array<float, 3>>(); const auto a1 = in.take<std::array<float, 6>>(); f.attenuate(a0.data(), a1.data()); },
        [](Rows& r) { many::attenuate(r.fields(), r.v(16), r.get<float, 6>(19)); });
changes("light_field_narrow", [](Field& f, In& in) { const auto a0 = in.take<std::array<float, 3>>(); const auto a1 = in.f(); f.narrow(a0.data(), a1); },
        [](Rows& r) { many::narrow(r.fields(), r.v(16), r.f(19)); });
changes("light_field_scatter", [](Field& f, In& in) { const auto a0 = in.take<std::array<float, 3>>(); const auto a1 = in.f(); f.scatter(a0.data(), a1); },
        [](Rows& r) { many::scatter(r.fields(), r.v(16), r.f(19)); });
changes("light_field_diffuse", [](Field& f, In& in) { const auto a0 = in.take<std::array<float, 3>>(); const auto a1 = in.take<std::array<float, 3>>(); f.diffuse(a0.data(), a1.data()); },
        [](Rows& r) { many::diffuse(r.fields(), r.v(16), r.v(19)); });
