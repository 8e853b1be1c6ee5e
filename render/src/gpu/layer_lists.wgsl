// The lists of samples: those of sample k end at ends[k], and begin where those before it end.
#import layered

fn first_layer(k: u32) -> u32 {
    if k == 0u {
        return 0u;
    }
    return ends[k - 1u];
}
