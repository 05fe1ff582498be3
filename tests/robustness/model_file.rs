use foldwing::config;
#[test]
fn shipped() {
    println!("{}", config::schema());
    for e in std::fs::read_dir("examples/models").unwrap() {
        let p = e.unwrap().path();
        if p.extension().unwrap() == "toml" {
            match config::read(&p) {
                Ok((m, _)) => println!("{}: {m:#?}", p.display()),
                Err(e) => println!("ERR {e}"),
            }
        }
    }
}
